// ids_exact.wgsl with an alpha test; alpha_test.wgsl comes after this text.
//
// Vertex buffers 0 and 1: as in ids_exact.wgsl. Vertex buffer 2, per vertex: texture coordinates times q, 0, q, where q is 1 / w
// times a factor that the corners of a triangle share.
// Output: as in ids.wgsl.

struct Vertex {
    @location(0) p_ndc: vec3f,
    @location(1) ids: vec2u,
    @location(2) uvq: vec4f,
}

struct Varyings {
    @builtin(position) p_clip: vec4f,
    @location(0) @interpolate(flat, either) ids: vec2u,
    @location(1) uvq: vec3f,
}

@vertex
fn clip_position(v: Vertex) -> Varyings {
    return Varyings(vec4f(v.p_ndc, 1.0), v.ids, v.uvq.xyw);
}

@fragment
fn ids(v: Varyings) -> @location(0) vec2u {
    if !exists(v.uvq) {
        discard;
    }
    return v.ids;
}
