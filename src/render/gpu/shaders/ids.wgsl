// Which triangle of which instance is nearest: depth.wgsl, with two numbers a pixel.
//
// Vertex buffers and clip space: as in depth.wgsl.
// Output: (slot + 1, index of the triangle in its mesh); the target is cleared to 0. A slot is a place in the pass's list
// of visible instances.

enable primitive_index;

struct Vertex {
    @location(0) p_local: vec3f,
    @location(1) column_x: vec4f,
    @location(2) column_y: vec4f,
    @location(3) column_z: vec4f,
    @location(4) column_w: vec4f,
    @builtin(instance_index) slot: u32,
}

struct Varyings {
    @builtin(position) p_clip: vec4f,
    @location(0) @interpolate(flat, either) slot: u32,
}

@vertex
fn clip_position(v: Vertex) -> Varyings {
    // The same operations as in depth.wgsl.
    let p_clip = ((v.column_x * v.p_local.x + v.column_y * v.p_local.y) + v.column_z * v.p_local.z) + v.column_w;
    return Varyings(p_clip, v.slot);
}

@fragment
fn ids(v: Varyings, @builtin(primitive_index) triangle: u32) -> @location(0) vec2u {
    return vec2u(v.slot + 1, triangle);
}
