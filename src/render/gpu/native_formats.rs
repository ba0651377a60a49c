//! Native depth formats of the device, held against the numbers that shaders/stored.wgsl rounds to. Tests alone.
//!
//! Maps are drawn in single precision and rounded afterwards: to nearest, on every device. A native target saves that pass, but a
//! device need not round to nearest there, and half a step of bias would not cover that; nor can a depth24plus target be copied.

use wgpu::{
    CompareFunction, DepthStencilState, PipelineCompilationOptions, PrimitiveState, RenderPipeline,
    RenderPipelineDescriptor, TextureFormat, VertexState,
};

use super::device::Gpu;
use super::device::tests::opened;
use super::exact::Depths;
use super::layer_pipelines::Encoding;
use super::passes::{DepthPipelines, InUse, Session, State, Target, layer_view};
use super::pipelines::{DEPTH, Pipelines, VERTEX_BUFFERS, module};
use super::readback::{STAGING, copy_depth, depth_bytes, finish_and_read, unpad};
use super::renderer::FEATURES;
use crate::error::Result;
use crate::progress::Progress;
use crate::render::{Format, Keep, Stored};
use crate::scene::library;
use crate::techniques::technique_of;

const SIZE: [u32; 2] = [256, 192];
/// Of numbers near 1 in single precision, which either side is handed.
const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;

/// depth.wgsl into a native target.
fn native_pipeline(gpu: &Gpu, format: TextureFormat) -> RenderPipeline {
    let module = module(&gpu.device, "native depth", include_str!("shaders/depth.wgsl").into());
    gpu.device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("native depth"),
        layout: None,
        vertex: VertexState {
            module: &module,
            entry_point: Some("clip_position"),
            compilation_options: PipelineCompilationOptions::default(),
            buffers: &VERTEX_BUFFERS,
        },
        primitive: PrimitiveState::default(),
        depth_stencil: Some(DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}

/// A scene's map in a native target and as stored.wgsl rounds it. A shader reads the target: not every format can be copied.
fn native_and_stored(gpu: &Gpu, name: &str, native: TextureFormat, format: Format) -> Result<[Vec<f32>; 2]> {
    let s = library::build(name, 1, &[])?;
    let p = technique_of("lispsm:near=delta-z,range=body,fit=exact")?
        .parameterize(&s.scene, &s.camera, &s.light, SIZE[0])?;
    let (pipelines, progress) = (Pipelines::new(gpu)?, Progress::new());
    let mut session = Session { gpu, pipelines: &pipelines, state: &mut State::default(), progress: &progress };
    let mut in_use = InUse::default();
    let mut encoder = gpu.encoder("native depth");
    let clips = [p.partitions[0].shadow_clip_from_world];
    let list = session.list(&mut in_use, &s.scene, &clips, SIZE, (Depths::Forward, &[Keep::InVolume]), false)?;
    assert!(!list.is_tested(), "{name} has alpha tests, which this draws without");
    let drawn = session.state.pool.texture(gpu, native, SIZE, 1)?;
    let drawn = layer_view(&drawn, 0);
    let depth = DepthPipelines { plain: native_pipeline(gpu, native), tested: None };
    session.record(&mut encoder, &mut in_use, &list, 0, &drawn, &depth, Target::FORWARD)?;
    let read = session.state.pool.texture(gpu, DEPTH, SIZE, 1)?;
    let as_it_is = session.state.layers.encoding(gpu, Encoding::of(Stored::default()));
    let settings = bytemuck::Zeroable::zeroed();
    session.encode(&mut encoder, &mut in_use, &as_it_is, &settings, [&drawn, &drawn], &layer_view(&read, 0))?;
    let stored = Stored { format, ..Stored::default() };
    let ours = session.draw_stored(
        &mut encoder,
        &mut in_use,
        &s.scene,
        &p.partitions[..1],
        SIZE,
        stored,
        &[Keep::InVolume],
    )?;
    let mut maps = [read, ours].map(|texture| (texture, vec![0.0; (SIZE[0] * SIZE[1]) as usize]));
    for (texture, map) in &mut maps {
        let mut recorded = std::mem::replace(&mut encoder, gpu.encoder("native depth"));
        let bytes = depth_bytes(SIZE, 1);
        let staging = session.state.pool.buffer(gpu, STAGING, bytes)?;
        copy_depth(&mut recorded, texture, &staging);
        let take = |padded: &[u8]| unpad(padded, SIZE[0] as usize, map);
        finish_and_read(gpu, &mut session.state.pool, recorded, staging, bytes, &progress, take)?;
    }
    Ok(maps.map(|(_, map)| map))
}

/// Texels of which two maps differ by more than a step, and by anything.
fn differing([a, b]: &[Vec<f32>; 2], step: f64) -> [usize; 2] {
    let apart = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs());
    let (mut over, mut any) = (0, 0);
    for apart in apart {
        // NaN differs.
        over += usize::from(!(apart <= step + ROUNDING));
        any += usize::from(!(apart <= ROUNDING));
    }
    [over, any]
}

#[test]
fn native_formats_give_what_is_stored_to_a_step() {
    let Some(gpu) = opened(FEATURES) else { return };
    for (native, format) in
        [(TextureFormat::Depth16Unorm, Format::Unorm16), (TextureFormat::Depth24Plus, Format::Unorm24)]
    {
        for name in ["robots", "courtyard"] {
            let maps = native_and_stored(&gpu, name, native, format).unwrap();
            let covered = maps[1].iter().filter(|z| **z < 1.0).count();
            let [over, any] = differing(&maps, format.step(0.99));
            println!("{name}, {native:?}: {any} of {covered} texels differ, {over} by more than a step");
            assert!(covered > maps[1].len() / 10, "{name}: an empty map agrees with anything");
            assert_eq!(over, 0, "{name}, {native:?}");
        }
    }
}

#[test]
fn the_comparison_sees_two_steps_in_one_texel() {
    for format in [Format::Unorm16, Format::Unorm24] {
        let step = format.step(0.5);
        let map: Vec<f32> = (0..100).map(|i| format.quantise(i as f32 / 101.0)).collect();
        let mut other = map.clone();
        assert_eq!(differing(&[map.clone(), other.clone()], step), [0, 0]);
        other[50] += (2.0 * step + 4.0 * ROUNDING) as f32;
        assert_eq!(differing(&[map, other], step), [1, 1], "{format:?}");
    }
}
