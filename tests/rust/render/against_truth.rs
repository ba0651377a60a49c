//! Shadow masks held against traced truth: with a fine map, wrong pixels lie at the edges of shadows and things, and are few.
//!
//! A nearest lookup answers for the centre of its texel, so a wrong answer needs an edge in the map within a texel or so. An
//! edge in the map is where neighbours in the image differ: in what rays say, in the thing they show, or by a crease.
//! Distances are therefore taken twice, in pixels of the image (an edge between two pixels is seen by both) and in texels of
//! the map. Receivers so steep that `slope_limit` holds their slope back are counted apart.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use shadowlab::image::{GBuffer, TruthMask};
use shadowlab::parameterization::Parameterization;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::cpu::lookup::{Comparison, MapLookup};
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::{DirectionalLight, library};
use shadowlab::trace::Tracer;
use shadowlab::{Camera, Light, Mesh, Progress, Scene};

use crate::support::by_body::by_body;
use crate::support::cpu::reach_texels;

const SIZE: [u32; 2] = [320, 180];
/// Pixels, each way: an edge between two pixel centres is seen by both, and an edge thinner than a pixel by their neighbours.
const REACH_PIXELS: usize = 1;
/// Texels, each way: half to the centre that answers, and one for casters that leave their receiver at an angle, whose depth
/// must first outgrow the bias.
const REACH_TEXELS: f64 = 1.5;
/// Neighbours whose normals differ by more meet in a crease (cosine of 30 degrees); by less, they are facets of one surface.
const CREASE: f64 = 0.866;

/// What is compared: a view and its map.
struct Case<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    light: &'a Light,
    p: &'a Parameterization,
    resolution: u32,
    bias: Bias,
    filter: Filter,
}

/// Pixels by what can be said of them.
#[derive(Debug, Default, PartialEq)]
struct Verdict {
    compared: usize,
    wrong: usize,
    /// Wrong where the limit of the slope is at work.
    limited: usize,
    /// Wrong with neither an edge near nor a limit at work.
    unexplained: usize,
    /// Compared pixels that have an edge near: where the test cannot tell.
    near: usize,
}

impl Verdict {
    fn share(&self, n: usize) -> f64 {
        n as f64 / self.compared.max(1) as f64
    }
}

impl Case<'_> {
    fn gbuffer(&self) -> GBuffer {
        CpuRenderer::new().gbuffer(self.scene, self.camera, SIZE, &Progress::new()).unwrap()
    }
    fn truth(&self) -> Vec<i8> {
        let tracer = Tracer::new(self.scene, &Progress::new()).unwrap();
        tracer.shadow_mask(self.camera, self.light, SIZE, &Progress::new()).unwrap().data
    }
    fn mask(&self) -> Vec<f32> {
        let Self { bias, filter, .. } = *self;
        let settings = MaskSettings {
            resolution: [self.resolution; 2],
            size: SIZE,
            bias,
            filter,
            blend: 0.0,
            stored: Stored::default(),
        };
        let renderer = CpuRenderer::new();
        renderer.shadow_mask(self.scene, self.camera, self.light, self.p, &settings, &Progress::new()).unwrap().data
    }
    fn lookup(&self, bias: Bias) -> MapLookup {
        let size = [self.resolution; 2];
        MapLookup::new(
            &self.p.partitions[0],
            self.light,
            self.scene.origin(),
            size,
            bias,
            self.filter,
            Stored::default(),
        )
        .unwrap()
    }
    /// The view through the map of another scene.
    fn mask_through_map_of(&self, casters: &Scene) -> Vec<f32> {
        let size = [self.resolution; 2];
        let map = CpuRenderer::new().depth_maps(casters, self.p, size, Stored::default(), &Progress::new()).unwrap();
        let (g, lookup) = (self.gbuffer(), self.lookup(self.bias));
        let light = |pixel| match g.surfaces().receiver(pixel) {
            None => f32::NAN,
            Some((p, normal)) if self.light.illuminates(p + g.origin, normal) => lookup.light(&map.data, p, normal),
            Some(_) => 0.0,
        };
        (0..g.triangle.len()).map(light).collect()
    }

    fn verdict(&self, mask: &[f32], truth: &[i8]) -> Verdict {
        let g = self.gbuffer();
        let lookup = self.lookup(Bias { slope_limit: self.bias.slope_limit, ..Bias::default() });
        let unlimited = self.lookup(Bias { slope_limit: f64::INFINITY, ..Bias::default() });
        let receivers: Vec<_> = (0..truth.len()).map(|i| g.surfaces().receiver(i)).collect();
        let at = |l: &MapLookup, i: usize| match receivers[i].map(|(p, n)| l.compare_at(p, n)) {
            Some(Comparison::At(r)) => Some((r.p_texel, l.depth_at(&r, r.p_texel))),
            _ => None,
        };
        let texels: Vec<Option<DVec2>> = (0..truth.len()).map(|i| at(&lookup, i).map(|a| a.0)).collect();
        let edges = Edges::new(&g, truth, &texels, self.reach_texels(), self.resolution);
        let mut v = Verdict::default();
        for i in 0..truth.len() {
            let lit = match truth[i] {
                TruthMask::LIT => true,
                TruthMask::SHADOW => false,
                _ => continue,
            };
            if mask[i].is_nan() {
                continue;
            }
            let near = edges.is_near(i, texels[i]);
            v.compared += 1;
            v.near += usize::from(near);
            if (mask[i] >= 0.5) != lit {
                let limited = at(&lookup, i).map(|a| a.1) > at(&unlimited, i).map(|a| a.1);
                v.wrong += 1;
                v.limited += usize::from(limited && !near);
                v.unexplained += usize::from(!near && !limited);
            }
        }
        v
    }
    fn reach_texels(&self) -> f64 {
        // A filter that reaches further than half a texel asks further texels.
        REACH_TEXELS + reach_texels(self.filter) - 0.5
    }
}

/// Where neighbours in the image differ.
struct Edges {
    /// Pixels within [`REACH_PIXELS`] of one.
    pixels: Vec<bool>,
    /// Texels within reach of one.
    texels: Vec<bool>,
    resolution: usize,
}

impl Edges {
    fn new(g: &GBuffer, truth: &[i8], at: &[Option<DVec2>], reach: f64, resolution: u32) -> Self {
        let [width, height] = SIZE.map(|n| n as usize);
        let n = resolution as usize;
        let mut edges = Self { pixels: vec![false; truth.len()], texels: vec![false; n * n], resolution: n };
        let normal = |i: usize| DVec3::from_array(g.normal[i].map(f64::from));
        let differ = |i: usize, j: usize| {
            let same = g.instance[i] == g.instance[j] && normal(i).dot(normal(j)) >= CREASE;
            truth[i] != truth[j] || (g.triangle[i] >= 0 && !same)
        };
        for y in 0..height {
            for x in 0..width {
                let i = y * width + x;
                let right = (x + 1 < width).then_some(i + 1);
                let below = (y + 1 < height).then_some(i + width);
                for j in [right, below].into_iter().flatten() {
                    if differ(i, j) {
                        edges.mark_pixels([i, j]);
                        edges.mark_texels([at[i], at[j]], truth[i] != truth[j], reach);
                    }
                }
            }
        }
        edges
    }
    fn mark_pixels(&mut self, pair: [usize; 2]) {
        let [width, height] = SIZE.map(|n| n as usize);
        for i in pair {
            let (x, y) = (i % width, i / width);
            for row in y.saturating_sub(REACH_PIXELS)..(y + REACH_PIXELS + 1).min(height) {
                let from = row * width;
                let last = (x + REACH_PIXELS).min(width - 1);
                self.pixels[from + x.saturating_sub(REACH_PIXELS)..=from + last].fill(true);
            }
        }
    }
    /// The edge lies somewhere between the two; where that is a long way, the two show different things, and it ends at both.
    fn mark_texels(&mut self, ends: [Option<DVec2>; 2], is_shadow_edge: bool, reach: f64) {
        let [Some(a), Some(b)] = ends else {
            return ends.into_iter().flatten().for_each(|p| self.mark_around(p, reach));
        };
        const LONG: f64 = 16.0;
        let steps = (b - a).abs().max_element().ceil();
        if is_shadow_edge && steps <= LONG {
            (0..=steps as u32).for_each(|k| self.mark_around(a.lerp(b, f64::from(k) / steps.max(1.0)), reach));
        } else {
            [a, b].into_iter().for_each(|p| self.mark_around(p, reach));
        }
    }
    fn mark_around(&mut self, p: DVec2, reach: f64) {
        let end = self.resolution as f64 - 1.0;
        let low = (p - reach).floor().clamp(DVec2::ZERO, DVec2::splat(end)).as_u64vec2();
        let high = (p + reach).floor().clamp(DVec2::ZERO, DVec2::splat(end)).as_u64vec2();
        for y in low.y..=high.y {
            let row = y as usize * self.resolution;
            self.texels[row + low.x as usize..=row + high.x as usize].fill(true);
        }
    }
    fn is_near(&self, pixel: usize, p: Option<DVec2>) -> bool {
        let last = self.resolution - 1;
        let texel = |p: DVec2| (p.y as usize).min(last) * self.resolution + (p.x as usize).min(last);
        self.pixels[pixel] || p.is_some_and(|p| self.texels[texel(p)])
    }
}

fn scenes() -> Vec<(&'static str, library::LibraryScene)> {
    let build = |name, params: &[(&str, f64)]| {
        let params: Vec<_> = params.iter().map(|&(name, x)| (name.to_string(), x)).collect();
        library::build(name, 1, &params).unwrap()
    };
    let mut all = vec![];
    for name in library::names() {
        all.push((name, build(name, if name == "forest" { &[("trees", 200.0)] } else { &[] })));
    }
    all.push(("skylight under a spot", build("skylight", &[("spot", 1.0)])));
    all
}

/// Most wrong pixels of those compared, where a map of 4096 has texels about as large as the pixels. The worst has 0.018.
const WRONG_SHARE: f64 = 0.025;
/// Most wrong pixels of receivers whose slope is held back.
const LIMITED_SHARE: f64 = 5e-4;
/// Most pixels with an edge near, where the place of an error says nothing.
const NEAR_SHARE: f64 = 0.9;
/// Most wrong pixels without a reason: things thinner than a pixel cast shadows that no neighbour shows.
const UNEXPLAINED_SHARE: f64 = 2e-4;

#[test]
fn wrong_pixels_are_few_and_lie_at_edges() {
    scenes().par_iter().for_each(|(name, s)| {
        let (scene, camera, light) = (&s.scene, &s.camera, &s.light);
        let mut truth = None;
        for (technique, filters) in
            [("uniform", &Filter::PLAIN[..1]), ("lispsm", &Filter::PLAIN[..]), ("log_psm", &Filter::PLAIN[..1])]
        {
            let technique = by_body(technique);
            if !technique.spec().lights.serves(light) {
                continue;
            }
            let p = technique.parameterize(scene, camera, light, 4096).unwrap();
            for &(filter_name, filter) in filters {
                let bias = Bias::default();
                let case = Case { scene, camera, light, p: &p, resolution: 4096, bias, filter };
                let truth = truth.get_or_insert_with(|| case.truth());
                let v = case.verdict(&case.mask(), truth);
                let what = format!("{name}, {}, {filter_name}: {v:?}", technique.spec().name);
                println!("{what}");
                assert!(v.compared > (SIZE[0] * SIZE[1]) as usize / 2, "{what}");
                assert!(v.share(v.wrong) <= WRONG_SHARE, "{what}");
                assert!(v.share(v.limited) <= LIMITED_SHARE, "{what}");
                assert!(v.share(v.unexplained) <= UNEXPLAINED_SHARE, "{what}");
                assert!(v.share(v.near) <= NEAR_SHARE, "{what}");
            }
        }
    });
}

#[test]
fn the_check_sees_acne_and_lost_casters() {
    let s = library::build("robots", 1, &[]).unwrap();
    let p = by_body("lispsm");
    let p = p.parameterize(&s.scene, &s.camera, &s.light, 2048).unwrap();
    let (scene, camera, light) = (&s.scene, &s.camera, &s.light);
    let case = |bias| Case { scene, camera, light, p: &p, resolution: 2048, bias, filter: Filter::Nearest };
    let whole = case(Bias::default());
    let truth = whole.truth();
    let v = whole.verdict(&whole.mask_through_map_of(scene), &truth);
    assert_eq!(v, whole.verdict(&whole.mask(), &truth), "the same map, looked up by hand");
    assert!(v.share(v.unexplained) <= UNEXPLAINED_SHARE, "{v:?}");
    // Without bias, the floor is full of acne.
    let bare = case(Bias::NONE);
    let v = bare.verdict(&bare.mask(), &truth);
    assert!(v.share(v.unexplained) > 100.0 * UNEXPLAINED_SHARE, "{v:?}");
    // A world unit of bias takes shadows away from the feet.
    let loose = case(Bias { world: 1.0, ..Bias::default() });
    let v = loose.verdict(&loose.mask(), &truth);
    assert!(v.share(v.unexplained) > 2.0 * UNEXPLAINED_SHARE && v.share(v.wrong) > WRONG_SHARE, "{v:?}");
    // A map without every other thing.
    let kept = scene.instances().iter().step_by(2).copied().collect();
    let fewer = Scene::new(scene.meshes().to_vec(), kept).unwrap();
    let v = whole.verdict(&whole.mask_through_map_of(&fewer), &truth);
    assert!(v.share(v.unexplained) > 10.0 * UNEXPLAINED_SHARE, "{v:?}");
}

/// A wall that the light all but misses, under a roof that keeps all light from it.
fn wall_under_a_roof() -> Scene {
    let v = |x: f64, y: f64, z: f64| [x, y, z];
    let wall = [v(-2.0, 0.0, 0.0), v(2.0, 0.0, 0.0), v(2.0, 2.5, 0.0), v(-2.0, 2.5, 0.0)];
    let level = |s: f64, y: f64| [v(-s, y, -s), v(s, y, -s), v(s, y, s), v(-s, y, s)];
    // The floor ends well within the roof, so that no edge of the map is in view. The roof is further above the wall than the
    // limit reaches: 16 texels of up to a tenth of a unit.
    let (roof, floor) = (level(8.0, 6.0), level(6.0, 0.0));
    let faces: Vec<[i64; 3]> = [0, 4, 8].into_iter().flat_map(|i| [[i, i + 1, i + 2], [i, i + 2, i + 3]]).collect();
    Scene::from_mesh(Mesh::new(&[wall, roof, floor].concat(), &faces).unwrap()).unwrap()
}

#[test]
fn a_grazing_wall_under_a_roof_is_in_shadow() {
    let scene = wall_under_a_roof();
    let camera =
        Camera::look_at(DVec3::new(0.0, 1.0, 4.0), DVec3::new(0.0, 1.2, 0.0), DVec3::Y, 0.8, 16.0 / 9.0, 0.1, 20.0);
    let camera = camera.unwrap();
    // Cosines between the wall's normal and the way to the light; at 0 it counts as turned away.
    for cosine in [1e-1, 1e-2, 1e-3, 1e-6] {
        let light = Light::Directional(DirectionalLight::new(DVec3::new(0.0, -1.0, -cosine)).unwrap());
        for technique in ["uniform", "lispsm"] {
            let technique = by_body(technique);
            for (filter_name, filter) in Filter::PLAIN {
                let p = technique.parameterize(&scene, &camera, &light, 512).unwrap();
                let case =
                    |bias| Case { scene: &scene, camera: &camera, light: &light, p: &p, resolution: 512, bias, filter };
                let false_light = |bias| {
                    let case = case(bias);
                    let (truth, mask) = (case.truth(), case.mask());
                    assert!(truth.iter().all(|&t| t != TruthMask::LIT), "the roof keeps all light away");
                    mask.iter().filter(|&&x| x >= 0.5).count()
                };
                let n = false_light(Bias::default());
                assert_eq!(n, 0, "{cosine}, {}, {filter_name}", technique.spec().name);
                // Without a limit the slope carries the wall through the roof.
                if cosine <= 1e-3 {
                    let n = false_light(Bias { slope_limit: f64::INFINITY, ..Bias::default() });
                    println!("{cosine}, {}, {filter_name}: {n}", technique.spec().name);
                    assert!(n > 0, "{cosine}, {}, {filter_name}: {n}", technique.spec().name);
                }
            }
        }
    }
}
