// ids.wgsl for triangles that the host has projected (exact.rs).
//
// Vertex buffer 0, per vertex: NDC of the viewport. Vertex buffer 1, per vertex: slot + 1, index of the triangle in its mesh.
// Output: as in ids.wgsl.

struct Vertex {
    @location(0) p_ndc: vec3f,
    @location(1) ids: vec2u,
}

struct Varyings {
    @builtin(position) p_clip: vec4f,
    @location(0) @interpolate(flat, either) ids: vec2u,
}

@vertex
fn clip_position(v: Vertex) -> Varyings {
    return Varyings(vec4f(v.p_ndc, 1.0), v.ids);
}

@fragment
fn ids(v: Varyings) -> @location(0) vec2u {
    return v.ids;
}
