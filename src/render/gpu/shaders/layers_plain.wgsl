// Depth of a map's layers; layers.wgsl comes before this text.
//
// Vertex buffers 0 and 1, clip space: as in depth.wgsl.
// Group 0: 0 the first depth of each texel, reversed.

@group(0) @binding(0) var first: texture_depth_2d;

struct Vertex {
    @location(0) p_local: vec3f,
    @location(1) column_x: vec4f,
    @location(2) column_y: vec4f,
    @location(3) column_z: vec4f,
    @location(4) column_w: vec4f,
}

struct Varyings {
    @builtin(position) @invariant p_clip: vec4f,
    @location(0) @interpolate(flat) outer: f32,
}

@vertex
fn clip_position(v: Vertex) -> Varyings {
    // The same operations as in depth.wgsl.
    let p_clip = ((v.column_x * v.p_local.x + v.column_y * v.p_local.y) + v.column_z * v.p_local.z) + v.column_w;
    return Varyings(p_clip, outer_turn(v.column_x, v.column_y, v.column_z, v.column_w));
}

@fragment
fn all() {
}

@fragment
fn averted(v: Varyings, @builtin(front_facing) turns_left: bool) {
    if !is_averted(turns_left, v.outer) {
        discard;
    }
}

@fragment
fn averted_reversed(v: Varyings, @builtin(front_facing) turns_left: bool) {
    if !is_averted(turns_left, -v.outer) {
        discard;
    }
}

@fragment
fn behind(v: Varyings) {
    if !(v.p_clip.z < textureLoad(first, vec2i(v.p_clip.xy), 0)) {
        discard;
    }
}
