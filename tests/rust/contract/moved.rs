//! A view at another scale and place has the same maps.

use std::collections::BTreeSet;

use glam::{DAffine3, DMat3, DVec3};
use shadowlab::focus::Samples;
use shadowlab::image::{GBuffer, Surfaces};
use shadowlab::parameterization::PostWarp;
use shadowlab::scene::{Camera, Light, SpotLight};
use shadowlab::survey::SURVEY_COUNT;
use shadowlab::techniques::{Kind, Needs, Technique, Value, technique, techniques_of, text_of};
use shadowlab::{Parameterization, Partition};

use super::RESOLUTION;
use super::answers::answer;
use super::checks::{Local, Receivers, own_view};
use super::promise::Promise;
use crate::support::settings::{BY_SAMPLES, settings};
use crate::support::views::{Random, View, by_hand, directional, picture_of, shaded_samples, spots};

fn moved(v: &View, scale: f64, offset: DVec3) -> View {
    let map = DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::splat(scale)), offset);
    let point = |p: DVec3| map.transform_point3(p);
    let c = &v.camera;
    let camera = Camera::look_at(
        point(c.eye()),
        point(c.eye() + c.forward()),
        c.up(),
        c.fov_y(),
        c.aspect(),
        c.near() * scale,
        c.far() * scale,
    );
    let light = match v.light {
        Light::Spot(l) => Light::Spot(
            SpotLight::new(point(l.position()), l.direction(), l.cone_angle(), l.range() * scale).expect("a spot"),
        ),
        other => other,
    };
    let name = format!("{} x {scale:e} + {offset}", v.name);
    View { name, scene: v.scene.transformed(&map).expect("moved"), camera: camera.expect("a camera"), light }
}

/// Samples of a view at another scale, a power of two where there are any, and place.
fn moved_samples(samples: &Samples, picture: &GBuffer, to: &View, scale: f64, offset: DVec3) -> Samples {
    let surfaces = picture.surfaces();
    let position: Vec<[f32; 3]> = surfaces.position.iter().map(|p| p.map(|x| x * scale as f32)).collect();
    let surfaces = Surfaces { origin: surfaces.origin * scale + offset, position: &position, ..surfaces };
    let shadows = samples.shadows.as_ref().expect("states");
    Samples::of_surfaces(&surfaces, &to.camera).with_shadows(&to.light, shadows.image.clone(), &surfaces, SURVEY_COUNT)
}

/// A technique with its lengths in the units of a world scaled by `scale`, its planes in one moved by `offset` after that, and
/// so those within it.
fn scaled(t: &dyn Technique, scale: f64, offset: DVec3) -> Box<dyn Technique> {
    // The largest number means no limit at any scale.
    let times = |x: f64, k: f64| (x * k).min(f64::MAX);
    let params = t.spec().params.iter().zip(t.settings());
    let params: Vec<(String, Value)> = params
        .map(|(p, (name, value))| {
            let value = match (value, p.kind, p.unit) {
                (Value::Number(x), _, "world units") => Value::Number(times(x, scale)),
                (Value::Number(x), _, "per world unit") => Value::Number(times(x, scale.recip())),
                (Value::Numbers(list), _, "world units") => {
                    Value::Numbers(list.into_iter().map(|x| times(x, scale)).collect())
                }
                (Value::Numbers(list), _, _) if name == "plane" => {
                    let moved = DVec3::new(list[0], list[1], list[2]).dot(offset);
                    Value::Numbers(vec![list[0], list[1], list[2], times(list[3], scale) - moved])
                }
                (Value::Choice(text), Kind::Techniques | Kind::Technique, _) => {
                    let inner = techniques_of(&text).expect("a technique made it");
                    let inner: Vec<String> = inner
                        .iter()
                        .map(|t| format!("({})", text_of(scaled(t.as_ref(), scale, offset).as_ref())))
                        .collect();
                    Value::Choice(inner.join("/"))
                }
                (value, ..) => value,
            };
            (name.to_string(), value)
        })
        .collect();
    technique(t.spec().name, &params).expect("made")
}

/// Corners of K are cuts of three planes, and the crop divides by their extents: a rounding of the input grows by this much
/// before the map's own steepness. Measured: 16 at most.
const CONDITION: f64 = 32.0;

/// The same of a map that is cut to corners of pixels, where rays of a picture meet the planes of f32 samples. Measured, at the
/// smallest warp distance there is: 41 at most.
const CONDITION_SEEN: f64 = 128.0;

/// Of the error of a map that is searched for: where a walk over its creases stops.
const SEARCHED: f64 = 1e-3;

/// The same of widths in pieces, of which a sample lies in one or the next as the search before them ends. Measured: 0.04.
const BINNED: f64 = 0.1;
/// The same where samples are fewer than pieces. Measured, with 60 of them: 0.11.
const SPARSE: f64 = 0.2;

/// The same of a part of a division, which has few samples, of which a grazing one weighs much; and of flips, which are counted.
/// Measured: 0.03.
const FEW: f64 = 0.05;

/// Compares a view's maps with those of the same view at another scale and place; nothing where rounding alone could move a
/// map by a few texels.
fn compare_moved(
    v: &View,
    a: &Parameterization,
    samples: &Samples,
    moved: &Moved,
    compared: &mut bool,
    vague: &mut bool,
) {
    let &Moved { ref name, ref p, scale, offset, snapped } = moved;
    assert_eq!(a.partitions.len(), p.partitions.len(), "{name}");
    let searched = [("error", SEARCHED), ("edge_width_even", SEARCHED), ("edge_width", BINNED)];
    let is_searched = |map: &Partition| searched.iter().any(|(value, _)| map.value(value).is_some());
    if a.partitions.iter().any(|map| BY_SAMPLES.contains(&map.technique) && is_searched(map)) {
        // The least of a flat error: what rounding decides is where in it the search ends, and in which piece a sample lies.
        for (a, p) in a.partitions.iter().zip(&p.partitions) {
            // Of divisions that cost the same rounding decides, too; their maps have other depths.
            let ends = |map: &Partition, scale: f64| map.eye_depth.map(|depth| depth * scale);
            let (ours, theirs) = (ends(a, scale), ends(p, 1.0));
            if (0..2).any(|i| (ours[i] / theirs[i] - 1.0).abs() > 1e-5) {
                continue;
            }
            let few = ["optimal_partition", "flips"].iter().any(|word| name.contains(word));
            let floor = if few { FEW } else { 0.0 };
            let sparse = if is_sparse(samples, a) { SPARSE } else { 0.0 };
            for (value, share) in searched {
                let share = if value == "edge_width" { share.max(sparse) } else { share }.max(floor);
                let [a, p] = [a, p].map(|map| map.value(value));
                let is_same = a.zip(p).map_or(a == p, |(a, p)| (a / p - 1.0).abs() < share);
                assert!(is_same, "{name}, {value}: {a:?} and {p:?}, not within {share}");
            }
        }
        *compared = true;
        return;
    }
    let r = Receivers::new(v);
    // The rounding of the moved scene's coordinates, and what each map makes of it.
    let size = v.scene.bounds().corners().iter().fold(r.view.origin.length(), |m, q| m.max(q.length()));
    let rounding = f64::EPSILON * (size + offset.length() / scale);
    let tolerances: Vec<f64> = (a.partitions.iter())
        .map(|partition| {
            let own = own_view(v, partition);
            let steepness = |q: &DVec3| steepness_at(partition, *q, own.origin);
            // Where a map holds samples alone, it is cut to the corners of their pixels, and w may be anything beyond.
            let promise = Promise::of(a);
            let corners = |(p, n): (DVec3, DVec3)| {
                let corners = samples.picture.expect("a picture").corners(p - v.camera.eye(), n);
                corners.map(|c| c + v.camera.eye() - own.origin)
            };
            let all: Vec<DVec3> = match promise {
                Promise::Body | Promise::Depths => own.receivers.vertices().to_vec(),
                Promise::Seen | Promise::Shadow => promise.held(v, samples).into_iter().flat_map(corners).collect(),
            };
            let steepest = all.iter().map(steepness).fold(0.0, f64::max);
            // The moved camera's direction is a difference of two points as far from the origin as the eye.
            let condition = if promise < Promise::Seen { CONDITION } else { CONDITION_SEEN };
            condition * (rounding * steepest).max(f64::EPSILON * v.camera.eye().length().max(1.0))
        })
        .collect();
    let shift = |k: usize| {
        let texels = p.partitions[k].project(offset).0 - a.partitions[k].project(DVec3::ZERO).0;
        let texels = texels.truncate() * 0.5 * f64::from(RESOLUTION);
        assert!(!snapped || texels.abs().max_element() < 1.0, "{name}: {texels} texels");
        if snapped { (texels * 2.0 / f64::from(RESOLUTION)).extend(0.0) } else { DVec3::ZERO }
    };
    let mut random = Random(5);
    for _ in 0..200 {
        let part = &r.boxes[random.below(r.boxes.len())];
        let q = Receivers::random_in(&mut random, part);
        let q_world = q + r.view.origin;
        let Some(k) = a.choose(q_world, v.camera.depth_of(q_world)).filter(|_| r.counts(q)) else { continue };
        // What is not held may lie where w is smaller.
        let tolerance = tolerances[k].max(CONDITION * rounding * steepness_at(&a.partitions[k], q, r.view.origin));
        if tolerance >= 0.01 {
            *vague = true;
            continue;
        }
        let one = a.partitions[k].project(q_world).0 + shift(k);
        let two = p.partitions[k].project(q_world * scale + offset).0;
        assert!((one - two).length() < tolerance, "{name}: {one} and {two}, {tolerance:e}");
        *compared = true;
    }
}

/// Whether a map has fewer samples at edges than pieces along an axis, so that one alone decides how long its piece is.
fn is_sparse(samples: &Samples, map: &Partition) -> bool {
    let edges = samples.shadows.as_ref().map_or(0, |shadows| shadows.edges.len());
    matches!(&map.post_warp, PostWarp::Rectilinear(warp) if edges < warp.x.knots().len())
}

/// The fastest that a map moves along an axis, at a point relative to an origin.
fn steepness_at(partition: &Partition, q: DVec3, origin: DVec3) -> f64 {
    let local = Local::new(partition, origin);
    [DVec3::X, DVec3::Y, DVec3::Z].iter().map(|d| local.derivative(q, *d)).fold(0.0, f64::max)
}

/// A view's maps at another scale and place.
struct Moved {
    name: String,
    p: Parameterization,
    scale: f64,
    offset: DVec3,
    /// Whether its texels stand still in the world, so that the place shifts them.
    snapped: bool,
}

#[test]
fn the_same_map_at_every_scale_and_far_from_the_origin() {
    let made = settings();
    let utm = DVec3::new(455_000.0, 5_411_000.0, -1_200.0);
    // A stable map's radius is rounded to a part of a power of two: those scales keep it.
    let powers = [(-20.0_f64).exp2(), 30.0_f64.exp2()];
    let plain = [(1e-6, DVec3::ZERO), (1e9, DVec3::ZERO), (1.0, utm), (1e-6, utm * 1e-6), (1e9, utm * 1e9)];
    let lattice = powers.iter().flat_map(|&s| [(s, DVec3::ZERO), (s, utm * s)]).chain([(1.0, utm)]);
    let lattice: Vec<_> = lattice.collect();
    let (mut all_compared, mut all_vague, mut unsuited) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    for (name, scene, camera) in by_hand().into_iter().filter(|s| ["cube", "town", "floor"].contains(&s.0)) {
        let picture = picture_of(&scene, &camera);
        let mut lights = spots(&scene, &camera);
        lights.truncate(1);
        lights.push(("slanted".into(), directional(DVec3::new(0.4, -1.0, -0.3))));
        for (light_name, light) in lights {
            let v = View { name: format!("{name} / {light_name}"), scene: scene.clone(), camera, light };
            let samples = shaded_samples(&scene, &camera, &light, &picture);
            for (setting, t) in made.iter().filter(|(_, t)| t.serves(&v.light).is_ok()) {
                // A spot's warp axis is taken at the mean of the body's vertices, and a face's borders meet the frustum's own
                // planes in single points: rounding decides how many vertices there are.
                if setting.contains("face_partition") && matches!(light, Light::Spot(_)) {
                    continue;
                }
                let stable = t.settings().contains(&("stable", Value::Flag(true)));
                let snapped = stable && matches!(light, Light::Directional(_));
                let what = format!("{} / {setting}", v.name);
                let map_of = |t: &dyn Technique, v: &View, samples: &Samples| {
                    answer(t, v, RESOLUTION, samples).unwrap_or_else(|e| panic!("{what}: {e}"))
                };
                let Some(a) = map_of(t.as_ref(), &v, &samples) else {
                    unsuited.insert(setting.as_str());
                    continue;
                };
                // Positions of samples are f32: times powers of two they stay what they are.
                let sampled = t.needs() != Needs::Nothing;
                for &(scale, offset) in if snapped || sampled { &lattice[..] } else { &plain[..] } {
                    let other = moved(&v, scale, offset);
                    let name = format!("{} / {setting}", other.name);
                    let seen = moved_samples(&samples, &picture, &other, scale, offset);
                    let b = map_of(scaled(t.as_ref(), scale, offset).as_ref(), &other, &seen);
                    // Where rounding takes all of a map, it is told.
                    let Some(p) = b else {
                        all_vague.insert(setting.as_str());
                        continue;
                    };
                    let (mut compared, mut vague) = (false, false);
                    let moved = Moved { name, p, scale, offset, snapped };
                    compare_moved(&v, &a, &samples, &moved, &mut compared, &mut vague);
                    all_compared.extend(compared.then_some(setting.as_str()));
                    all_vague.extend(vague.then_some(setting.as_str()));
                }
            }
        }
    }
    let all: BTreeSet<&str> = made.iter().map(|(name, _)| name.as_str()).collect();
    let answered: BTreeSet<&str> = all_compared.union(&unsuited).copied().collect();
    assert_eq!(answered, all);
    // The strongest warps: at their near end a rounding of the scene may be a texel, in some scenes; all are compared in
    // others. No default is as strong.
    println!("vague: {all_vague:?}");
    assert!(all_vague.iter().all(|setting| !setting.ends_with("()")), "{all_vague:?}");
}
