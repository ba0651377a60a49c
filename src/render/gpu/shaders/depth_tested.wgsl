// Depth of the nearest surface that exists: depth.wgsl with an alpha test; alpha_test.wgsl comes after this text.
//
// Vertex buffers 0 and 1, clip space: as in depth.wgsl.
// Vertex buffer 2, per vertex: texture coordinates times q, 0, q. Of triangles that the host has projected q is 1 / w, since
// their own w is 1; q is 1 where the device divides.

struct Vertex {
    @location(0) p_local: vec3f,
    @location(1) column_x: vec4f,
    @location(2) column_y: vec4f,
    @location(3) column_z: vec4f,
    @location(4) column_w: vec4f,
    @location(5) uvq: vec4f,
}

struct Varyings {
    @builtin(position) p_clip: vec4f,
    @location(0) uvq: vec3f,
}

@vertex
fn clip_position(v: Vertex) -> Varyings {
    // The same operations as in depth.wgsl.
    let p_clip = ((v.column_x * v.p_local.x + v.column_y * v.p_local.y) + v.column_z * v.p_local.z) + v.column_w;
    return Varyings(p_clip, v.uvq.xyw);
}

@fragment
fn depth(v: Varyings) {
    if !exists(v.uvq) {
        discard;
    }
}
