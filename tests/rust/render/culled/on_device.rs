//! The same on a device, whose maps are held against those that it draws itself.

use shadowlab::Progress;
use shadowlab::render::cpu::look_up;
use shadowlab::render::{Bias, Cull, Filter, MaskSettings, Renderer, Rule, Stored};

use super::setups::{among_blocks, maps_of};
use crate::support::gpu::renderer;

const SETTINGS: MaskSettings = MaskSettings {
    resolution: [128; 2],
    size: [96, 64],
    bias: Bias::NONE,
    filter: Filter::Bilinear,
    blend: 0.0,
    stored: Stored::FRONT,
};

#[test]
fn maps_and_masks_of_a_device_stay() {
    let Some(gpu) = renderer() else { return };
    let (v, progress) = (among_blocks(), Progress::new());
    let g = gpu.gbuffer(&v.scene, &v.camera, SETTINGS.size, &progress).unwrap();
    let mut left_out = 0;
    for (i, (name, p)) in maps_of(&v, 128).into_iter().enumerate() {
        if p.partitions.iter().any(|p| p.post_warp.name() != "none") {
            continue;
        }
        let stored = ["front", "back", "second", "dual:format=unorm16"][i % 4].parse().unwrap();
        let settings = MaskSettings { stored, ..SETTINGS };
        let map = |cull| gpu.maps_of(&v.scene, &p, [128; 2], stored, cull, &progress).unwrap().data;
        let whole = map(Cull::None);
        assert!(map(Cull::Volume) == whole, "{name}");
        let mask = |cull| {
            let mask = gpu.mask_of(&v.scene, &v.camera, &v.light, &p, &settings, cull, &progress).unwrap();
            mask.data.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
        };
        assert!(mask(Cull::Seen) == mask(Cull::None), "{name}");
        let seen = gpu.seen_maps(&v.scene, g.surfaces(), &v.camera, &v.light, &p, &settings, &progress).unwrap();
        let looked_up = |maps: &[f32]| {
            let found = look_up(maps, g.surfaces(), &v.camera, &v.light, &p, &settings, &progress).unwrap();
            found.data.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
        };
        assert!(looked_up(&seen.data) == looked_up(&whole), "{name}");
        let picture = Some((g.surfaces(), &v.camera, &v.light));
        let casters = gpu.casters(&v.scene, &p, Cull::Seen, picture, &settings, &progress).unwrap();
        assert!(casters.iter().all(|c| c.instances[Rule::Behind as usize] == 0), "{name}: texels alone count");
        left_out += casters.iter().map(|c| c.instances[Rule::Unseen as usize]).sum::<u64>();
    }
    assert!(left_out > 500, "{left_out}");
}
