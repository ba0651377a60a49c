//! The outline of receivers against the fit: whatever the warp, its corners span what the fit gives the map.

use glam::{DMat3, DVec3};
use shadowlab::fit::{Tightening, spot_depths};
use shadowlab::focus::{Coverage, Focus, FocusedView, receivers_extent};
use shadowlab::geometry::{Aabb, Rows};
use shadowlab::scene::{Camera, DirectionalLight, Light, Scene, SpotLight};
use shadowlab::techniques::kit::WarpSpace;
use shadowlab::techniques::lispsm::receivers_outline;

use crate::support::views::{Random, cube, look, placed};

/// Of an extent: roundings of two ways to the same corners, through w over three decades.
const EXACT: f64 = 1e-9;

/// Many small boxes about a camera, so that receivers have an outline of their own; light from anywhere, or a lamp.
fn swarm(random: &mut Random) -> (Scene, Camera, Light) {
    let count = 1 + random.below(300);
    let spread = DVec3::new(random.between(2.0, 60.0), random.between(0.1, 20.0), random.between(2.0, 60.0));
    let mut parts = Vec::new();
    for _ in 0..count {
        let turn = DMat3::from_axis_angle(random.direction(), random.between(0.0, 6.0));
        let half = DVec3::new(random.between(0.0, 2.0), random.between(0.0, 2.0), random.between(0.1, 2.0));
        parts.push((cube(), turn * DMat3::from_diagonal(half), random.direction() * spread));
    }
    let eye = random.direction() * random.between(0.0, 30.0);
    let camera = look(eye, eye + random.direction(), random.between(0.3, 2.0), 0.3, 90.0);
    let light = if random.below(3) == 0 {
        let at = random.direction() * 40.0;
        Light::Spot(
            SpotLight::new(at, random.direction() * 10.0 - at, random.between(0.4, 2.0), 150.0).expect("a lamp"),
        )
    } else {
        Light::Directional(DirectionalLight::new(random.direction()).expect("a light"))
    };
    (placed(&parts), camera, light)
}

/// Where a warp acts in a view; nothing where nothing is seen or nothing can be warped.
fn space_of(view: &FocusedView, scene: &Scene) -> Option<WarpSpace> {
    let towards = view.camera.forward();
    match (view.coverage, &view.light, view.spot()) {
        (Coverage::AsAsked, Light::Directional(l), _) => WarpSpace::directional(view, l.direction(), towards).ok(),
        (Coverage::AsAsked, _, Some(spot)) => {
            WarpSpace::spot(view, &spot, spot_depths(&spot, view, scene).range, towards).ok()
        }
        _ => None,
    }
}

#[test]
fn its_corners_span_every_warps_map() {
    let mut random = Random(11);
    let (mut count, mut own) = (0, 0);
    while count < 300 {
        let (scene, camera, light) = swarm(&mut random);
        let view = FocusedView::new(&scene, &camera, &light, Focus::SceneFit);
        let Some(space) = space_of(&view, &scene) else { continue };
        let outline = receivers_outline(&space.rows, &view, &scene, Tightening::Exact);
        let whole = receivers_outline(&space.rows, &view, &scene, Tightening::None);
        assert!(outline.is_fit && whole.is_fit);
        own += usize::from(outline.corners != whole.corners);
        // A point of the space's own NDC, in the map of a warp: x and y from the rows, as the space's w is 1 there.
        let flat = Rows { x: glam::DVec4::X, y: glam::DVec4::Y, z: glam::DVec4::ZERO, w: glam::DVec4::W };
        for lambda in [1e3, 3.0, 1.0, 0.3, 0.03, 1e-3] {
            let distance = lambda * space.extent();
            let fitted = receivers_extent(&space.warped(distance), &view, &scene);
            let image = WarpSpace { rows: flat, ..space }.warped(distance);
            let spanned = Aabb::from_points(outline.corners.iter().map(|p| image.project(p.extend(0.0))));
            let off = ((spanned.min - fitted.min).abs().max((spanned.max - fitted.max).abs())).truncate();
            let extent = fitted.extent().truncate();
            assert!(off.cmple(EXACT * extent).all(), "{count}, {lambda}: {off} of {extent}");
        }
        count += 1;
    }
    assert!(own > 100, "{own} outlines that are not the body's");
}
