//! The library's scenes: few pixels are undecided, the same answer every time, memory within its limit.

use shadowlab::Progress;
use shadowlab::image::TruthMask;
use shadowlab::scene::library;
use shadowlab::trace::Tracer;

/// Undecided pixels of those that show something: rare, so that a comparison of techniques loses nothing.
const MOST_UNDECIDED: f64 = 1e-3;
/// Bytes beside the input for each triangle that is stored once.
const MOST_BYTES: f64 = 250.0;

#[test]
fn every_scene_has_a_clear_answer() {
    for name in library::names() {
        let made = library::build(name, 1, &[]).unwrap();
        let tracer = Tracer::new(&made.scene, &Progress::new()).unwrap();
        let mask = || tracer.shadow_mask(&made.camera, &made.light, [256, 192], &Progress::new()).unwrap().data;
        let data = mask();
        let count = |value: i8| data.iter().filter(|&&v| v == value).count();
        let (lit, shadow, undecided) = (count(TruthMask::LIT), count(TruthMask::SHADOW), count(TruthMask::UNDECIDED));
        let triangles: usize = made.scene.meshes().iter().map(|m| m.triangles().len()).sum();
        let bytes = tracer.memory() as f64 / (triangles + made.scene.instances().len()) as f64;
        println!("{name}: {lit} lit, {shadow} in shadow, {undecided} undecided, {bytes:.0} bytes a triangle");
        assert!(lit > 1000 && shadow > 1000, "{name}: {lit} lit, {shadow} in shadow");
        assert!(undecided as f64 <= MOST_UNDECIDED * (lit + shadow) as f64, "{name}: {undecided} undecided");
        assert!(bytes <= MOST_BYTES, "{name}: {bytes}");
        assert_eq!(data, mask(), "{name}: another answer the second time");
    }
}
