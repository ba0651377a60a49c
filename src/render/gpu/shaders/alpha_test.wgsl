// Which points of a triangle exist, by the alpha test of its mesh: src/scene/alpha_test.rs in single precision.
//
// Group 0: 0 the test, 1 the levels of its texture, 0 to 255.
// Part of depth_tested.wgsl, ids_tested.wgsl and ids_exact_tested.wgsl, which come before this text.

struct AlphaTest {
    // Texels across and down.
    size: vec2i,
    // Along u and v: 0 repeats, 1 mirrors, 2 clamps.
    wrap: vec2u,
    // Least level that exists.
    threshold: f32,
}

@group(0) @binding(0) var<uniform> alpha_test: AlphaTest;
@group(0) @binding(1) var levels: texture_2d<u32>;

// The place in [0, 1] that a coordinate reads.
fn folded(u: f32, wrap: u32) -> f32 {
    let twice = u - 2.0 * floor(0.5 * u);
    // No branch asks a uniform: see pipelines.rs.
    let mirrored_or_clamped = select(clamp(u, 0.0, 1.0), min(twice, 2.0 - twice), wrap == 1);
    return select(mirrored_or_clamped, u - floor(u), wrap == 0);
}

// The texel at a place, at most one beside the texture.
fn texel(at: i32, wrap: u32, count: i32) -> i32 {
    return select(clamp(at, 0, count - 1), (at + count) % count, wrap == 0);
}

fn level(x: i32, y: i32) -> f32 {
    return f32(textureLoad(levels, vec2i(x, y), 0).x);
}

fn mixed(a: f32, b: f32, part: f32) -> f32 {
    return a + (b - a) * part;
}

// Whether a point with texture coordinates (u, v) times q exists.
fn exists(uvq: vec3f) -> bool {
    let uv = uvq.xy / uvq.z;
    let size = alpha_test.size;
    let place = vec2f(folded(uv.x, alpha_test.wrap.x), folded(uv.y, alpha_test.wrap.y)) * vec2f(size) - 0.5;
    let first = floor(place);
    let part = place - first;
    let at = vec2i(first);
    let left = texel(at.x, alpha_test.wrap.x, size.x);
    let right = texel(at.x + 1, alpha_test.wrap.x, size.x);
    let upper = texel(at.y, alpha_test.wrap.y, size.y);
    let lower = texel(at.y + 1, alpha_test.wrap.y, size.y);
    let upper_level = mixed(level(left, upper), level(right, upper), part.x);
    let lower_level = mixed(level(left, lower), level(right, lower), part.x);
    return mixed(upper_level, lower_level, part.y) >= alpha_test.threshold;
}
