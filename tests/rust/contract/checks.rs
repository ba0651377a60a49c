//! What one parameterization is held against: the contract itself.

use glam::{DMat3, DMat4, DVec3, DVec4};
use shadowlab::Parameterization;
use shadowlab::focus::{Coverage, Focus, FocusedView, Samples, SpotFrustum};
use shadowlab::geometry::{OrientedBox, Rows};
use shadowlab::note::{Kind, Note};
use shadowlab::parameterization::{Factors, Held, Partition, PostWarp};
use shadowlab::rays::LightRays;
use shadowlab::scene::{Light, SpotLight};
use shadowlab::techniques::Value;

use super::TOLERANCE;
use super::promise::Promise;
use crate::support::measure::inset;
use crate::support::views::{Random, View};

/// What a map of this view has to show: points of instances' boxes that the camera can see and the light reaches.
pub struct Receivers {
    pub boxes: Vec<OrientedBox>,
    /// To coordinates in which the box is [-1, 1]³; not finite for a flat box.
    inverses: Vec<DMat3>,
    pub view: FocusedView<'static>,
    /// The pyramids of a placed light: one of a spot, six around a point.
    pyramids: Vec<SpotFrustum>,
}

impl Receivers {
    pub fn new(v: &View) -> Self {
        let view = FocusedView::new(&v.scene, &v.camera, &v.light, Focus::SceneFit);
        let placed = |i| OrientedBox::new(v.scene.mesh_of(i).bounds_local(), &v.scene.world_from_local(i), view.origin);
        let boxes: Vec<OrientedBox> = (0..v.scene.instances().len()).map(placed).collect();
        let inverses = boxes.iter().map(|b| DMat3::from_cols(b.half[0], b.half[1], b.half[2]).inverse()).collect();
        let pyramids = match v.light {
            Light::Directional(_) => Vec::new(),
            Light::Spot(_) => view.spot().into_iter().collect(),
            Light::Point(light) => {
                let quarter = std::f64::consts::FRAC_PI_2;
                let face = |axis| SpotLight::new(light.position(), axis, quarter, light.range()).expect("a face");
                let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
                axes.map(|axis| SpotFrustum::new(&face(axis), view.origin, &view.scene_box)).collect()
            }
        };
        Self { boxes, inverses, view, pyramids }
    }
    pub fn random_in(random: &mut Random, b: &OrientedBox) -> DVec3 {
        b.center + b.half.iter().map(|h| *h * random.between(-1.0, 1.0)).sum::<DVec3>()
    }
    /// Random points in the instances' boxes.
    pub fn some(&self) -> Vec<DVec3> {
        let mut random = Random(11);
        let mut one = || {
            let i = random.below(self.boxes.len());
            Self::random_in(&mut random, &self.boxes[i])
        };
        std::iter::repeat_with(&mut one).take(100).collect()
    }
    /// Some of what a map promises to hold.
    fn some_held(&self, v: &View, p: &Parameterization, samples: &Samples) -> Vec<DVec3> {
        let promise = Promise::of(p);
        let seen = || {
            let held = promise.held(v, samples);
            held.iter().step_by(1 + held.len() / 100).map(|(q, _)| *q - self.view.origin).collect::<Vec<_>>()
        };
        let body = || self.some().into_iter().filter(|q| self.counts(*q));
        match (promise, &p.partitions[..]) {
            (Promise::Body, _) => body().collect(),
            (Promise::Depths, [map]) => {
                let depths = own_depths(map);
                let within = |q: &DVec3| {
                    let depth = v.camera.depth_of(*q + self.view.origin);
                    (depths[0]..=depths[1]).contains(&depth)
                };
                body().filter(within).chain(seen()).collect()
            }
            _ => seen(),
        }
    }
    /// Whether a local point can be seen and lit and is in the scene's box.
    pub fn counts(&self, p: DVec3) -> bool {
        self.view.receiver_planes().all(|plane| plane.distance(p) <= 0.0)
            && self.view.scene_box.contains(p)
            && (self.pyramids.is_empty() || self.pyramids.iter().any(|pyramid| is_in(pyramid, p)))
    }
    /// Whether a map can show a caster there: a placed light's begin somewhere.
    fn reached(&self, p: DVec3) -> bool {
        self.pyramids.iter().all(|pyramid| {
            let depth = (p - pyramid.frustum.apex).abs().max_element();
            // Of a spot the depth is that along its axis; of a point light's face, its axis is the longest component's.
            let depth = if self.pyramids.len() == 1 { pyramid.depth().dot(p.extend(1.0)) } else { depth };
            depth > pyramid.frustum.near
        })
    }
    /// Where the ray from p towards the light, in units of `to_light`, runs through a box: two distances.
    fn through(&self, i: usize, p: DVec3, to_light: DVec3) -> Option<(f64, f64)> {
        let (at, along) = (self.inverses[i] * (p - self.boxes[i].center), self.inverses[i] * to_light);
        if !at.is_finite() {
            return None;
        }
        let (mut near, mut far) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            let (a, d) = (at[axis], along[axis]);
            let (s, t) = ((-1.0 - a) / d, (1.0 - a) / d);
            if d == 0.0 && a.abs() > 1.0 {
                return None;
            }
            if d != 0.0 {
                (near, far) = (near.max(s.min(t)), far.min(s.max(t)));
            }
        }
        (near < far && far.is_finite()).then_some((near, far))
    }
}

fn is_in(pyramid: &SpotFrustum, p: DVec3) -> bool {
    pyramid.frustum.planes().iter().all(|plane| plane.distance(p) <= 0.0)
}

/// A map in coordinates relative to the eye, as it is made.
pub struct Local {
    pub rows: Rows,
    post_warp: PostWarp,
}

impl Local {
    pub fn new(partition: &Partition, origin: DVec3) -> Self {
        let rows = Rows::of(&(partition.shadow_clip_from_world * DMat4::from_translation(origin)));
        Self { rows, post_warp: partition.post_warp.clone() }
    }
    pub fn w(&self, p: DVec3) -> f64 {
        self.rows.w.dot(p.extend(1.0))
    }
    pub fn project(&self, p: DVec3) -> DVec3 {
        self.post_warp.apply(self.rows.project(p), self.w(p))
    }
    /// How fast it moves along a direction.
    pub fn derivative(&self, p: DVec3, direction: DVec3) -> f64 {
        let d = self.rows.derivative(p, direction);
        match &self.post_warp {
            PostWarp::None => d.length(),
            PostWarp::Rectilinear(warp) => {
                let slopes = warp.slopes(self.rows.project(p).truncate());
                (d.truncate() * slopes).extend(d.z).length()
            }
            // d(scale ln w) = scale dw / w.
            PostWarp::Log { scale, .. } => {
                DVec3::new(d.x, scale * self.rows.w.dot(direction.extend(0.0)) / self.w(p), d.z).length()
            }
        }
    }
}

/// What a map of several has to show, where a directional or spot light's view tells: the depths and rays that it serves.
pub fn own_view(v: &View, partition: &Partition) -> FocusedView<'static> {
    let [near, far] = own_depths(partition);
    let camera = v.camera.with_depths(near, far).unwrap_or(v.camera);
    FocusedView::new(&v.scene, &camera, &v.light, Focus::SceneFit).restricted(&v.scene, &partition.region)
}

/// The depths that a map is made for: those of what is seen, where it is made for that.
fn own_depths(partition: &Partition) -> [f64; 2] {
    let [near, far] = partition.eye_depth;
    [partition.value("seen_near").unwrap_or(near), partition.value("seen_far").unwrap_or(far)]
}

/// All of the contract that a result can show by itself.
pub fn assert_contract(what: &str, v: &View, r: &Receivers, p: &Parameterization, samples: &Samples) {
    assert!(!p.partitions.is_empty(), "{what}: no map");
    let seen = r.view.coverage == Coverage::AsAsked;
    for (k, partition) in p.partitions.iter().enumerate() {
        let what = format!("{what}, map {k}");
        let m = partition.shadow_clip_from_world;
        assert!(m.is_finite(), "{what}: {m:?}");
        let [near, far] = partition.eye_depth;
        let begins = near > 0.0 || v.camera.is_orthographic();
        assert!(begins && near <= far && far.is_finite(), "{what}: {:?}", partition.eye_depth);
        assert!(partition.values.iter().all(|(_, x)| x.is_finite()), "{what}: {:?}", partition.values);
        assert!(partition.region.functionals().iter().all(|f| f.is_finite()), "{what}: {:?}", partition.region);
        let rows = Rows::of(&m);
        // (0.1): the rows x, y, w vanish on the light, up to the rounding of their terms.
        let light = v.light.point();
        let across = [rows.x, rows.y, rows.w];
        let terms = across.iter().map(|row| (*row * light).abs().element_sum()).fold(0.0, f64::max);
        for row in across {
            assert!(row.dot(light).abs() <= 1e-12 * terms, "{what}: {row} on {light}");
        }
        assert!(rows.z.dot(light) != 0.0, "{what}: depth does not see the light");
        if seen && !matches!(v.light, Light::Point(_)) && Promise::of(p) <= Promise::Depths {
            assert_own_view(&what, v, r, partition, p.partitions.len());
        }
    }
    // Where nothing is seen there is no receiver; maps that say so cover all that the light reaches.
    let says_so = |note: &Note| matches!(note.kind(), Kind::NothingSeen | Kind::NothingLit) && note.maps().is_none();
    let all_say_so = p.notes.iter().any(says_so);
    if seen || all_say_so {
        assert_pairs(what, v, r, p, samples);
    }
}

/// The factors of each matrix: a homography on the light's rays, a crop that divides by nothing, and their product.
pub fn assert_factors(what: &str, p: &Parameterization) {
    for (k, partition) in p.partitions.iter().enumerate() {
        let what = format!("{what}, map {k}");
        let Factors { lift, warp, fit } = partition.factors.expect("a technique's map has factors");
        let (warped, fitted) = (Rows::of(&warp), Rows::of(&fit));
        for row in [warped.x, warped.y, warped.w] {
            assert_eq!(row.z, 0.0, "{what}: the warp reads the place along a ray: {row}");
        }
        assert_eq!(fitted.w.truncate(), DVec3::ZERO, "{what}: {fit}");
        assert!(fitted.w.w > 0.0, "{what}: {fit}");
        let (off, matrix) = (fit * warp * lift - partition.shadow_clip_from_world, partition.shadow_clip_from_world);
        let largest = |m: &DMat4| m.to_cols_array().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        assert!(largest(&off) <= 1e-12 * largest(&matrix), "{what}: off by {off} from {matrix}");
        // Row by row a little more: the place of a map that is narrow against its distance from the eye and from the world's
        // origin is a difference of larger terms, of which the matrix has the rounding, too.
        for (off, row) in rows_of(&off).into_iter().zip(rows_of(&matrix)) {
            let relative = off.abs().max_element() / row.abs().max_element();
            assert!(relative <= 2e-12, "{what}: off by {relative:e}: {off} from {row}");
        }
    }
}

fn rows_of(m: &DMat4) -> [DVec4; 4] {
    let Rows { x, y, z, w } = Rows::of(m);
    [x, y, z, w]
}

/// w and orientation over all that the map serves.
fn assert_own_view(what: &str, v: &View, r: &Receivers, partition: &Partition, count: usize) {
    let whole = count == 1 && partition.value("seen_near").is_none();
    let own = if whole { r.view } else { own_view(v, partition) };
    if own.coverage == Coverage::NothingSeen {
        return;
    }
    let local = Local::new(partition, own.origin);
    for q in own.receivers.vertices() {
        assert!(local.w(*q) > 0.0, "{what}: w <= 0 at {q}");
    }
    let rays = LightRays::new(&v.light, own.origin);
    assert_eq!(rays.orientation(&local.rows, own.receivers.vertex_mean()), 1.0, "{what}: orientation");
}

/// Random receivers lie inside the border of a map that is made for them, and find a map that holds them; there, whatever box
/// a ray from them to the light meets shares x and y, lies in [0, 1] and before them.
fn assert_pairs(what: &str, v: &View, r: &Receivers, p: &Parameterization, samples: &Samples) {
    let fit = |word: &str| p.settings.contains(&("fit", Value::Choice(word.into())));
    if fit("published") {
        // Loses casters and is offered as that; tests/rust/techniques/xpsm.rs shows it.
        return;
    }
    // This fit leaves out receivers that nothing casts on.
    let only_cast_on = fit("intersection");
    // Samples may be served by a map that is made for others.
    let promise = Promise::of(p);
    let by_samples = promise >= Promise::Seen;
    let inset = inset(p).x;
    let locals: Vec<Local> = p.partitions.iter().map(|partition| Local::new(partition, r.view.origin)).collect();
    let rays = LightRays::new(&v.light, r.view.origin);
    let holds = |k: usize, q: DVec3| {
        let ndc = locals[k].project(q);
        let across = ndc.truncate().abs().max_element();
        let inside = across <= inset + TOLERANCE && (-TOLERANCE..=1.0 + TOLERANCE).contains(&ndc.z);
        p.partitions[k].region.contains(q + r.view.origin) && locals[k].w(q) > 0.0 && inside
    };
    let seen = r.view.coverage == Coverage::AsAsked;
    let receivers = r.some_held(v, p, samples);
    // Maps of a placed light among its casters begin at a distance, and say so.
    let begins = p.partitions.iter().filter_map(|map| map.value("begins_at")).fold(0.0, f64::max) * (1.0 + TOLERANCE);
    let shown = |q: DVec3| v.light.to_light(q + r.view.origin).length() > begins;
    let shown: &dyn Fn(DVec3) -> bool = if matches!(v.light, Light::Directional(_)) { &|_| true } else { &shown };
    for q in receivers.into_iter().filter(|q| shown(*q)) {
        let q_world = q + r.view.origin;
        let depth = v.camera.depth_of(q_world);
        let within = |[near, far]: [f64; 2]| (near..=far).contains(&depth);
        // The rounding of a depth at the ends of all of them, where there is no other map.
        let served = |k: usize| {
            let [near, far] = p.partitions[k].eye_depth;
            let room = |depth: f64| {
                TOLERANCE * if v.camera.is_orthographic() { depth.abs().max(v.camera.volume().height()) } else { depth }
            };
            !seen || within([near - room(near), far + room(far)])
        };
        let made_for = (0..locals.len()).find(|&k| served(k) && holds(k, q));
        assert!(
            made_for.is_some() || only_cast_on || by_samples && p.partitions.len() > 1,
            "{what}: receiver {q} at depth {depth} in no map"
        );
        if let Some(k) = made_for {
            assert_eq!(rays.orientation(&locals[k].rows, q), 1.0, "{what}, map {k}: orientation at {q}");
        }
        let chosen = p.choose(q_world, depth);
        let chosen = chosen.filter(|&k| p.partitions[k].holds(q_world) == Held::Within);
        let images = || p.partitions.iter().map(|map| (map.eye_depth, map.project(q_world))).collect::<Vec<_>>();
        assert!(
            chosen.is_some() || only_cast_on,
            "{what}: receiver {q} at depth {depth} finds no map: {:?}, {promise:?}",
            images()
        );
        assert_casters(what, v, r, q, chosen.map(|k| &locals[k]), shown);
    }
}

/// What any box between a receiver and the light shows in the receiver's map.
fn assert_casters(what: &str, v: &View, r: &Receivers, q: DVec3, map: Option<&Local>, shown: &dyn Fn(DVec3) -> bool) {
    let mut random = Random(q.x.to_bits() ^ q.z.to_bits());
    let to_light = match v.light {
        Light::Directional(l) => -l.direction(),
        Light::Spot(l) => l.position() - r.view.origin - q,
        Light::Point(l) => l.position() - r.view.origin - q,
    };
    let all = r.boxes.len() <= 64;
    for i in 0..if all { r.boxes.len() } else { 16 } {
        let other = if all { i } else { random.below(r.boxes.len()) };
        let Some((near, far)) = r.through(other, q, to_light) else { continue };
        let far = if matches!(v.light, Light::Directional(_)) { far } else { far.min(1.0) };
        if near >= far {
            continue;
        }
        // The farthest point of every second box: nothing may be cut off there.
        let at = if i % 2 == 0 { far * (1.0 - 1e-9) } else { random.between(near, far) };
        let caster = q + to_light * at;
        let apart = (caster - q).length() > 1e-9 * r.view.scene_box.diagonal();
        if !(apart && at > 0.0 && r.reached(caster) && shown(caster)) {
            continue;
        }
        let Some(map) = map else { panic!("{what}: receiver {q} under {caster} in no map") };
        let (ndc, image) = (map.project(q), map.project(caster));
        assert!(map.w(caster) > 0.0, "{what}: w = {} at {caster} over {q} with {}", map.w(caster), map.w(q));
        assert!((image - ndc).truncate().abs().max_element() < TOLERANCE, "{what}: {image} over {ndc}");
        assert!(image.z >= -TOLERANCE && image.z < ndc.z + 1e-12, "{what}: caster {image} over {ndc}");
    }
}
