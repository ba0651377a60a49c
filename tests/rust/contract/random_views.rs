//! Ten thousand random configurations for every technique: a correct map or a typed error, never anything else.
//!
//! A configuration is a scene (a single point to thirty kilometres), a camera (fields of view from 1 to 170 degrees, far over
//! near from 1.001 to a million and infinite, aspects from 0.05 to 20, pictures beside the view axis, parallel rays, the eye
//! inside boxes), a light (parallel to the view, to its up, or hardly off that) and a
//! resolution; every technique gets all of them, with random settings now and then. The environment variables
//! SHADOWLAB_CONFIGURATIONS (a count) and SHADOWLAB_CONFIGURATION (one number) choose others.

#[allow(dead_code, reason = "shared with the contract tests")]
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};
use rayon::prelude::*;
use shadowlab::focus::Samples;
use shadowlab::geometry::Rows;
use shadowlab::image::TruthMask;
use shadowlab::note::Kind;
use shadowlab::parameterization::PostWarp;
use shadowlab::rays::{LightFrame, LightRays};
use shadowlab::render::Renderer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::scene::Light;
use shadowlab::techniques::{Needs, TECHNIQUES, Technique, Value, technique};
use shadowlab::{Error, Parameterization, Partition, Progress};

use super::answers::margin_is_too_wide;
use super::configuration::{Configuration, random_settings};
use super::promise::Promise;
use crate::support::boxes::Boxes;
use crate::support::views::{Random, View};

const COUNT: u64 = 10_000;
/// Receivers looked at in each map; each with all casters above it.
const POINTS: usize = 16;
/// Pixels along the longer side of the picture that samples come from.
const PICTURE: f64 = 24.0;

/// Of f64 in the rows of a matrix and in the coordinates of a point: a dozen operations, and the cuts of three planes that
/// bound a body (measured: 16 roundings at most).
const ROUNDINGS: f64 = 1024.0 * f64::EPSILON;
/// A map in which NDC is not known to this is not looked at: less than a hundredth of the map.
const VAGUE: f64 = 0.01;

/// A thousandth of a texel in NDC, times the resolution: receivers beyond their border by that are far inside of the map. The
/// crop of a strong warp to receivers that begin far behind its near end cancels more digits than the matrix shows.
const SLIGHT: f64 = 2e-3;

/// How one configuration went.
#[derive(Debug, Default, Clone)]
struct Tally {
    maps: u64,
    receivers: u64,
    casters: u64,
    vague: u64,
    errors: BTreeMap<String, u64>,
    refused: u64,
    failures: Vec<String>,
}

impl Tally {
    fn join(mut self, other: Self) -> Self {
        self.maps += other.maps;
        self.receivers += other.receivers;
        self.casters += other.casters;
        self.vague += other.vague;
        self.refused += other.refused;
        for (kind, count) in other.errors {
            *self.errors.entry(kind).or_default() += count;
        }
        self.failures.extend(other.failures);
        self
    }
}

/// What the rounding of a world point, found relative to `origin`, and of a map's rows makes of NDC, and of w relative to it.
fn rounding(partition: &Partition, p_world: DVec3, origin: DVec3) -> (f64, f64) {
    let rows = Rows::of(&partition.shadow_clip_from_world);
    let size = p_world.length() + origin.length();
    let terms = |row: DVec4| (row * p_world.extend(1.0)).abs().element_sum() + row.truncate().length() * size;
    let clip = rows.clip(p_world);
    let of_w = ROUNDINGS * terms(rows.w) / clip.w.abs();
    let [x, y, z] = [(rows.x, clip.x), (rows.y, clip.y), (rows.z, clip.z)]
        .map(|(row, c)| ROUNDINGS * terms(row) / clip.w.abs() + of_w * (c / clip.w).abs());
    match &partition.post_warp {
        PostWarp::None => (x.max(y).max(z), of_w),
        PostWarp::Log { scale, .. } => (x.max(y).max(z).max(scale.abs() * of_w), of_w),
        PostWarp::Rectilinear(warp) => {
            let slopes = warp.slopes((clip / clip.w).truncate().truncate());
            ((x * slopes.x).max(y * slopes.y).max(z), of_w)
        }
    }
}

/// Whether triangles keep the winding that the light sees; nothing where that is lost in rounding.
fn keeps_winding(rows: &Rows, rays: &LightRays, p: DVec3, origin: DVec3) -> Option<bool> {
    let frame = LightFrame::any(rays.direction_at(p)?);
    let on = |v: DVec4| DVec3::new(rows.x.dot(v), rows.y.dot(v), rows.w.dot(v));
    let h = DMat3::from_cols(on(frame.right.extend(0.0)), on(frame.up.extend(0.0)), on(p.extend(1.0)));
    // Each entry may be off by a rounding of its row, or of the row's terms at the point.
    let terms = |row: DVec4| (row * p.extend(1.0)).abs().element_sum() + row.truncate().length() * origin.length();
    let [x, y, w] = [rows.x, rows.y, rows.w].map(|row| DVec2::new(row.truncate().length(), terms(row)));
    let size = x.x * y.x * w.y + x.x * y.y * w.x + x.y * y.x * w.x;
    (h.determinant().abs() > ROUNDINGS * size).then(|| h.determinant() * h.z_axis.z > 0.0)
}

fn check(
    c: &Configuration,
    boxes: &Boxes,
    p: &Parameterization,
    samples: Option<&Samples>,
    random: &mut Random,
    tally: &mut Tally,
) {
    assert!(!p.partitions.is_empty(), "no map");
    let light = c.light.point();
    for partition in &p.partitions {
        let m = partition.shadow_clip_from_world;
        assert!(m.is_finite(), "not finite: {m:?}");
        assert!(partition.values.iter().all(|v| v.1.is_finite()), "not finite: {:?}", partition.values);
        let [near, far] = partition.eye_depth;
        let begins = near > 0.0 || c.camera.is_orthographic();
        assert!(begins && near.is_finite() && near <= far && far.is_finite(), "depths {near} {far}");
        if let PostWarp::Log { scale, offset } = partition.post_warp {
            assert!(scale.is_finite() && offset.is_finite() && scale != 0.0, "logarithm {scale} {offset}");
        }
        let rows = Rows::of(&m);
        for row in [rows.x, rows.y, rows.w] {
            let along = row.dot(light);
            // Subnormal numbers have fewer digits, and a part of a row below the rounding of the rest has none.
            let rest = f64::EPSILON * row.truncate().length() * light.length();
            let size = ((row * light).abs().element_sum() + rest).max(f64::MIN_POSITIVE / f64::EPSILON);
            assert!(along.abs() <= ROUNDINGS * size, "(0.1): {row} on {light} is {along:e}; {rows:?}");
        }
        // Where w spans more than depth has digits for, or a light far from the origin stands near what it lights.
        let sees = rows.z.dot(light).abs() > ROUNDINGS * (rows.z * light).abs().element_sum();
        if !sees {
            tally.vague += 1;
            return;
        }
    }
    let fit = |word: &str| p.settings.contains(&("fit", Value::Choice(word.into())));
    if fit("published") {
        return;
    }
    let gaps = fit("intersection");
    let stable = p.settings.contains(&("stable", Value::Flag(true)));
    // Maps may be made for what is seen and no more.
    let promise = Promise::of(p);
    let view = View { name: c.what.clone(), scene: c.scene.clone(), camera: c.camera, light: c.light };
    let sampled = samples.filter(|_| promise != Promise::Body).map(|samples| promise.held(&view, samples));
    // Of a surface that runs along the light up to f32, as positions are, rounding decides which side is lit.
    let faces = |(q, n): &(DVec3, DVec3)| n.dot(c.light.to_light(*q).normalize()) > f64::from(f32::EPSILON);
    let sampled = sampled.map(|all| all.into_iter().filter(faces).map(|(q, _)| q).collect::<Vec<_>>());
    // A sample lies up to a step of f32 beside its surface.
    let step = sampled.as_ref().and(samples).map_or(0.0, |samples| {
        let reach = samples.points.iter().flatten().fold(0.0_f32, |most, x| most.max(x.abs()));
        2.0 * f64::from(f32::EPSILON * reach)
    });
    // Maps of a placed light among its casters begin at a distance, and say so.
    let begins = p.partitions.iter().filter_map(|map| map.value("begins_at")).fold(0.0, f64::max) * (1.0 + 1e-9);
    // A placed light within the scene's box says the depth, along its axis or that of a face, at which its maps begin.
    let notes = p.notes.iter().chain(p.partitions.iter().flat_map(|map| &map.notes));
    let in_box = notes.filter(|note| note.kind() == Kind::LightInBox).flat_map(|note| note.values());
    let in_box = in_box.map(|(_, distance)| distance.most).fold(0.0, f64::max) * (1.0 + 1e-9);
    let shown = |q: DVec3| {
        let v = c.light.to_light(q + boxes.origin);
        let depth = match &c.light {
            Light::Spot(spot) => (-v).dot(spot.direction()).min(v.abs().max_element()),
            _ => v.abs().max_element(),
        };
        (begins == 0.0 || v.length() > begins) && (in_box == 0.0 || depth > in_box)
    };
    for _ in 0..POINTS {
        let receiver = match &sampled {
            Some(points) if points.is_empty() => None,
            Some(points) => Some(points[random.below(points.len())] - boxes.origin),
            None => boxes.receiver(random).map(|receiver| receiver.p),
        };
        let Some(receiver) = receiver.filter(|q| shown(*q)) else { continue };
        let q = receiver + boxes.origin;
        // What a sample lies below by a rounding of its place is its own surface.
        let to_light = c.light.to_light(q).normalize();
        let mut above = boxes.casters(receiver, random);
        above.retain(|caster| (*caster - receiver).dot(to_light) > step);
        let Some(chosen) = p.choose(q, c.camera.depth_of(q)) else {
            if gaps && above.is_empty() {
                continue;
            }
            // On the rim of a map, up to rounding.
            let rim = p.partitions.iter().any(|partition| {
                let (ndc, w) = partition.project(q);
                let (room, of_w) = rounding(partition, q, boxes.origin);
                let known = room < VAGUE && of_w < VAGUE;
                !known || (w > 0.0 && ndc.truncate().abs().max_element() <= 1.0 + room && ndc.z <= 1.0 + room)
            });
            assert!(
                rim,
                "no map holds the receiver {q}: {:?}",
                p.partitions.iter().map(|m| m.project(q)).collect::<Vec<_>>()
            );
            tally.vague += 1;
            continue;
        };
        let partition = &p.partitions[chosen];
        let (ndc, w) = partition.project(q);
        let (room, of_w) = rounding(partition, q, boxes.origin);
        if !(room < VAGUE && of_w < VAGUE) {
            tally.vague += 1;
            continue;
        }
        tally.receivers += 1;
        // With several maps the border of one may hold what another is made for; a stable one moves by up to a texel.
        let border = if p.partitions.len() == 1 && !stable { p.border_texels } else { 0 };
        let texels = f64::from(p.resolution[0]);
        let inset = 1.0 - 2.0 * f64::from(border) / texels;
        let local = Rows::of(&(partition.shadow_clip_from_world * DMat4::from_translation(boxes.origin)));
        let per_step = [DVec3::X, DVec3::Y, DVec3::Z].map(|d| local.derivative(receiver, d).z.abs());
        let ends = room + step * per_step.iter().sum::<f64>();
        let inside = w > 0.0
            && ndc.truncate().abs().max_element() <= inset + room + SLIGHT / texels
            && (-ends..=1.0 + ends).contains(&ndc.z);
        assert!(
            inside || (gaps && above.is_empty()),
            "map {chosen}: receiver {q} at {ndc}, w {w:e}, rounding {room:e}, {:?}",
            partition.values
        );
        let Some(keeps_winding) = keeps_winding(&local, &boxes.parts[0].view.rays, receiver, boxes.origin) else {
            tally.vague += 1;
            continue;
        };
        assert!(keeps_winding, "map {chosen}: mirrored at {q}");
        for caster in above.into_iter().filter(|q| shown(*q)) {
            let (image, w) = partition.project(caster + boxes.origin);
            let (more, of_w) = rounding(partition, caster + boxes.origin, boxes.origin);
            let room = room + more;
            if !(room < VAGUE && of_w < VAGUE) {
                continue;
            }
            tally.casters += 1;
            let apart = (image - ndc).truncate().abs().max_element();
            assert!(
                w > 0.0 && apart <= room,
                "map {chosen}: caster {image}, w {w:e}, above {ndc}: {apart:e} > {room:e}"
            );
            let before = image.z >= -ends - more && image.z < ndc.z + room;
            assert!(before, "map {chosen}: caster {image} before {ndc}, rounding {room:e}");
        }
    }
}

/// What a small picture shows, with shadows anywhere: a random line divides it, and random pixels are of another state.
fn random_samples(c: &Configuration, random: &mut Random) -> Samples {
    let root = c.camera.aspect().max(1.0);
    let size = [PICTURE * c.camera.aspect() / root, PICTURE / root].map(|n| n.round().max(1.0) as u32);
    let picture = CpuRenderer::new().gbuffer(&c.scene, &c.camera, size, &Progress::new()).expect("a picture");
    let (across, share) = (random.direction(), random.unit() * 0.2);
    let states = [TruthMask::LIT, TruthMask::SHADOW, TruthMask::UNDECIDED];
    let state = |pixel: u32| {
        let [x, y] = [pixel % size[0], pixel / size[0]].map(|n| f64::from(n) - 0.5 * PICTURE);
        let side = usize::from(across.dot(DVec3::new(x, y, 0.3 * PICTURE)) > 0.0);
        states[if random.unit() < share { random.below(3) } else { side }]
    };
    let image = (0..size[0] * size[1]).map(state).collect();
    let surfaces = picture.surfaces();
    Samples::of_surfaces(&surfaces, &c.camera).with_shadows(&c.light, image, &surfaces, 256)
}

fn attempt(c: &Configuration, t: &dyn Technique, boxes: &Boxes, random: &mut Random, tally: &mut Tally) {
    let samples = (t.needs() != Needs::Nothing).then(|| random_samples(c, random));
    match t.parameterize_seen(&c.scene, &c.camera, &c.light, [c.resolution; 2], samples.as_ref()) {
        Ok(p) => {
            tally.maps += 1;
            check(c, boxes, &p, samples.as_ref(), random, tally);
        }
        Err(Error::UnsuitedView { technique, reason, .. }) => {
            let digits = |ch: char| ch.is_ascii_digit();
            let kind = reason.split(digits).next().unwrap_or_default();
            *tally.errors.entry(format!("{technique}: {kind}")).or_default() += 1;
        }
        // Three texels have no room beside their borders.
        Err(Error::InvalidArgument { name, .. }) if name == "margin" && margin_is_too_wide(t, c.resolution) => {
            tally.refused += 1;
        }
        Err(error) => panic!("an error of another kind: {error}"),
    }
}

/// One configuration for all techniques, by name.
fn run(seed: u64) -> BTreeMap<&'static str, Tally> {
    let c = Configuration::random(seed);
    let boxes = Boxes::new(&c.scene, &c.camera, &c.light, c.resolution);
    let served = TECHNIQUES.iter().filter(|entry| entry.spec.lights.serves(&c.light));
    let mut all = BTreeMap::new();
    // It makes a map for every run of eight intervals, each of them the search of scene_optimal.
    let served = served.filter(|entry| entry.spec.name != "optimal_partition" || seed.is_multiple_of(8));
    for entry in served {
        let mut random = Random(seed.wrapping_mul(31) ^ 0x5EED);
        let mut tally = Tally::default();
        let settings = random_settings(entry.spec, &c, &mut random);
        match technique(entry.spec.name, &settings) {
            // A combination of settings that contradict each other.
            Err(Error::InvalidArgument { .. }) if !settings.is_empty() => tally.refused += 1,
            Err(error) => tally.failures.push(format!("{}: {error}", entry.spec.name)),
            Ok(t) => {
                let went = catch_unwind(AssertUnwindSafe(|| attempt(&c, t.as_ref(), &boxes, &mut random, &mut tally)));
                if let Err(panic) = went {
                    let text = panic.downcast_ref::<String>().cloned();
                    let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| s.to_string()));
                    let name = entry.spec.name;
                    let text = text.unwrap_or_default();
                    tally.failures.push(format!("configuration {seed}, {name} {settings:?}: {text}\n    {c:?}"));
                }
            }
        }
        all.insert(entry.spec.name, tally);
    }
    all
}

#[test]
fn every_technique_makes_a_correct_map_or_says_why_not() {
    let of_environment = |name: &str| std::env::var(name).ok().map(|n| n.parse::<u64>().expect("a number"));
    let seeds = match of_environment("SHADOWLAB_CONFIGURATION") {
        Some(one) => one..one + 1,
        None => 0..of_environment("SHADOWLAB_CONFIGURATIONS").unwrap_or(COUNT),
    };
    let many = seeds.end - seeds.start >= COUNT;
    // Panics are caught and counted; their traces would hide the list of them.
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let all = seeds.into_par_iter().map(run).reduce(BTreeMap::new, |mut a, b| {
        for (name, tally) in b {
            let before = a.remove(name).unwrap_or_default();
            a.insert(name, Tally::join(before, tally));
        }
        a
    });
    std::panic::set_hook(hook);
    let mut failed = 0;
    for (name, t) in &all {
        let errors: u64 = t.errors.values().sum();
        println!(
            "{name}: {} maps, {} receivers, {} casters, {} too vague, {errors} errors, {} settings refused, {} failures",
            t.maps,
            t.receivers,
            t.casters,
            t.vague,
            t.refused,
            t.failures.len()
        );
        for (kind, count) in &t.errors {
            println!("    {count} x {kind}");
        }
        for failure in t.failures.iter().take(4) {
            println!("  FAILED {failure}");
        }
        failed += t.failures.len();
    }
    assert_eq!(failed, 0, "see the output");
    if many {
        assert_eq!(all.len(), TECHNIQUES.len());
        for (name, t) in &all {
            // A view that shows nothing lit has no dominant plane, and one that shows nothing no samples.
            let unlit = |kind: &&String| kind.contains("none of the") || kind.contains("fewer than three");
            let errors: u64 = t.errors.iter().filter(|(kind, _)| !unlit(kind)).map(|(_, count)| count).sum();
            assert!(errors <= t.maps, "{name}: {errors} errors and {} maps", t.maps);
            assert!(t.receivers > t.maps && t.casters > t.maps / 4, "{name}: hardly anything was looked at");
            assert!(t.vague < t.receivers / 4, "{name}: {} of {} too vague", t.vague, t.receivers);
        }
    }
}
