// ids.wgsl for devices that do not tell a fragment its triangle: every triangle has three vertices of its own, read from the
// buffers by number, so that the vertex knows its triangle.
//
// Group 0: 0 placements of the visible instances (see surface.wgsl), 1 columns of clip_from_local for each, 2 p_local
// of the meshes of a group, 3 their vertex indices. Vertex number: place in the index buffer.
// Output: as in ids.wgsl.

struct Placement {
    eye_from_local_x: array<vec4f, 2>,
    eye_from_local_y: array<vec4f, 2>,
    eye_from_local_z: array<vec4f, 2>,
    first_vertex: u32,
    first_index: u32,
    instance: u32,
    unused: u32,
}

@group(0) @binding(0) var<storage, read> placements: array<Placement>;
@group(0) @binding(1) var<storage, read> clip_from_local: array<mat4x4f>;
@group(0) @binding(2) var<storage, read> vertices: array<f32>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;

struct Varyings {
    @builtin(position) p_clip: vec4f,
    @location(0) @interpolate(flat, either) ids: vec2u,
}

@vertex
fn clip_position(@builtin(vertex_index) place: u32, @builtin(instance_index) slot: u32) -> Varyings {
    let first_vertex = placements[slot].first_vertex;
    let at = 3 * (first_vertex + indices[place]);
    let m = clip_from_local[slot];
    // The same operations as in depth.wgsl.
    let p_clip = ((m[0] * vertices[at] + m[1] * vertices[at + 1]) + m[2] * vertices[at + 2]) + m[3];
    return Varyings(p_clip, vec2u(slot + 1, (place - placements[slot].first_index) / 3));
}

@fragment
fn ids(v: Varyings) -> @location(0) vec2u {
    return v.ids;
}
