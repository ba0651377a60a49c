// Depth of the nearest surface: vertices to the clip space of a map or an eye; the fixed pipeline does the rest.
//
// Vertex buffer 0, per vertex:   p_local, the mesh's local frame.
// Vertex buffer 1, per instance: columns of clip_from_local.
// Output: clip space, 0 <= z <= w, y up.

struct Vertex {
    @location(0) p_local: vec3f,
    @location(1) column_x: vec4f,
    @location(2) column_y: vec4f,
    @location(3) column_z: vec4f,
    @location(4) column_w: vec4f,
}

@vertex
fn clip_position(v: Vertex) -> @builtin(position) vec4f {
    // In this order of operations, the one of the CPU renderer: the pictures agree to the last sub-pixel step.
    return ((v.column_x * v.p_local.x + v.column_y * v.p_local.y) + v.column_z * v.p_local.z) + v.column_w;
}
