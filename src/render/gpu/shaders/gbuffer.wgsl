// The G-buffer out of the ids of a pass; surface.wgsl comes before this text.
//
// Group 1: 0 depth of the pass (1 at near to 0 at far), 1 result: for the n pixels of the rows at hand n depths, 3n of position relative to
// the scene's origin (world units), 3n of normal, n triangles, n instances.

@group(1) @binding(0) var depth: texture_depth_2d;
@group(1) @binding(1) var<storage, read_write> result: array<u32>;

fn write(at: u32, v: vec3f) {
    result[at] = bitcast<u32>(v.x);
    result[at + 1] = bitcast<u32>(v.y);
    result[at + 2] = bitcast<u32>(v.z);
}

@compute @workgroup_size(8, 8)
fn gbuffer(@builtin(global_invocation_id) invocation: vec3u) {
    let pixel = pixel_of(invocation);
    if pixel.z == 0 {
        return;
    }
    let id = textureLoad(ids, pixel.xy, 0).xy;
    if !is_mine(id) {
        return;
    }
    let n = view.width * view.rows;
    let i = invocation.y * view.width + invocation.x;
    result[i] = bitcast<u32>(1.0 - textureLoad(depth, pixel.xy, 0));
    if id.x == 0 {
        write(n + 3 * i, vec3f());
        write(4 * n + 3 * i, vec3f());
        result[7 * n + i] = 0xffffffff;
        result[8 * n + i] = 0xffffffff;
        return;
    }
    let s = surface(pixel.xy, id);
    write(n + 3 * i, vec3f(real(view.unit) * s.p_eye + eye_minus_origin()));
    write(4 * n + 3 * i, vec3f(s.normal));
    result[7 * n + i] = s.triangle;
    result[8 * n + i] = s.instance;
}
