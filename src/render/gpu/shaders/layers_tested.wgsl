// Depth of a map's layers, of surfaces that exist: layers_plain.wgsl with an alpha test; layers.wgsl comes before this text,
// alpha_test.wgsl after it.
//
// Vertex buffers 0 to 2, clip space: as in depth_tested.wgsl.
// Group 1: 0 the first depth of each texel, reversed.

@group(1) @binding(0) var first: texture_depth_2d;

struct Vertex {
    @location(0) p_local: vec3f,
    @location(1) column_x: vec4f,
    @location(2) column_y: vec4f,
    @location(3) column_z: vec4f,
    @location(4) column_w: vec4f,
    @location(5) uvq: vec4f,
}

struct Varyings {
    @builtin(position) @invariant p_clip: vec4f,
    @location(0) @interpolate(flat) outer: f32,
    @location(1) uvq: vec3f,
}

@vertex
fn clip_position(v: Vertex) -> Varyings {
    // The same operations as in depth.wgsl.
    let p_clip = ((v.column_x * v.p_local.x + v.column_y * v.p_local.y) + v.column_z * v.p_local.z) + v.column_w;
    return Varyings(p_clip, outer_turn(v.column_x, v.column_y, v.column_z, v.column_w), v.uvq.xyw);
}

@fragment
fn all(v: Varyings) {
    if !exists(v.uvq) {
        discard;
    }
}

@fragment
fn averted(v: Varyings, @builtin(front_facing) turns_left: bool) {
    if !is_averted(turns_left, v.outer) || !exists(v.uvq) {
        discard;
    }
}

@fragment
fn averted_reversed(v: Varyings, @builtin(front_facing) turns_left: bool) {
    if !is_averted(turns_left, -v.outer) || !exists(v.uvq) {
        discard;
    }
}

@fragment
fn behind(v: Varyings) {
    if !(v.p_clip.z < textureLoad(first, vec2i(v.p_clip.xy), 0)) || !exists(v.uvq) {
        discard;
    }
}
