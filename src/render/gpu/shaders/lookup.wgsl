// The light that arrives at each pixel through the shadow maps; twin of cpu/lookup.rs; surface.wgsl comes before this text.
//
// Space: "eye" of surface.wgsl, lengths in its unit. Space "texel": the map in texels, x to the right, y down.
// Group 1: 0 the light, its bias and the filter, 1 one record a map, 2 the maps, 3 result: a value in [0, 1] for each pixel of
// the rows at hand, -1 where nothing is.

struct Lookup {
    // The light's centre: (unit vector to the light, 0) or (position, 1).
    light: vec4f,
    // Of a spot: its unit axis, and the cosine of half its cone's angle; -2 without a cone.
    cone: vec4f,
    range: f32,
    bias_world: f32,
    bias_texels: f32,
    bias_ndc: f32,
    slope: f32,
    slope_limit: f32,
    // 0: one comparison with the texel the point falls into. 1: bilinear weights over the four nearest.
    filter_kind: u32,
    maps: u32,
}

struct Map {
    // Rows of shadow_clip_from_eye.
    row_x: vec4f,
    row_y: vec4f,
    row_z: vec4f,
    row_w: vec4f,
    // The last camera depth this map serves, in x.
    depth_end: vec4f,
}

@group(1) @binding(0) var<uniform> lookup: Lookup;
@group(1) @binding(1) var<storage, read> maps: array<Map>;
@group(1) @binding(2) var depth_maps: texture_depth_2d_array;
@group(1) @binding(3) var<storage, read_write> result: array<f32>;

// Larger than any bias that leaves a depth in [0, 1]; stands for infinity, which WGSL need not know.
const BOUNDLESS = 1e30;

struct Comparison {
    p_texel: vec2f,
    z: f32,
    // Lit without a look at the map: outside of it, behind its projection centre, or nearer than its near plane.
    is_lit: bool,
}

const LIT = Comparison(vec2f(), 0.0, true);

fn to_light(p: vec3f) -> vec3f {
    let v = lookup.light.xyz - lookup.light.w * p;
    let size = length(v);
    return select(vec3f(), v / size, size > 0.0);
}

// Whether light could arrive: the normal is turned towards the light, and the point is within its cone and range.
fn faces_light(p: vec3f, normal: vec3f) -> bool {
    let v = lookup.light.xyz - lookup.light.w * p;
    if !(dot(normal, v) > 0.0) {
        return false;
    }
    if lookup.light.w == 0.0 {
        return true;
    }
    let distance = length(v);
    return distance <= lookup.range && (lookup.cone.w < -1.0 || dot(-v, lookup.cone.xyz) >= distance * lookup.cone.w);
}

// The map that serves a camera depth: the first that does not end before it, else the last.
fn map_at(depth: f32) -> u32 {
    for (var i = 0u; i + 1 < lookup.maps; i++) {
        if depth <= maps[i].depth_end.x {
            return i;
        }
    }
    return lookup.maps - 1;
}

fn compare_at(m: Map, p: vec3f, normal: vec3f) -> Comparison {
    let p4 = vec4f(p, 1.0);
    let w = dot(m.row_w, p4);
    if !(w > 0.0) {
        return LIT;
    }
    let ndc = vec3f(dot(m.row_x, p4), dot(m.row_y, p4), dot(m.row_z, p4)) / w;
    if !(ndc.z >= 0.0) {
        return LIT;
    }
    let uv = vec2f(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
    if !(uv.x >= 0.0 && uv.x <= 1.0 && uv.y >= 0.0 && uv.y <= 1.0) {
        return LIT;
    }
    let size = vec2f(textureDimensions(depth_maps));

    // Gradients of the texel coordinates X and Y (down), and of NDC z.
    let grad_x = 0.5 * size.x * (m.row_x.xyz - ndc.x * m.row_w.xyz) / w;
    let grad_y = -0.5 * size.y * (m.row_y.xyz - ndc.y * m.row_w.xyz) / w;
    let grad_z = (m.row_z.xyz - ndc.z * m.row_w.xyz) / w;
    let across = cross(grad_x, grad_y);
    let toward = to_light(p);

    // Part 1: along the ray, by the world size of a texel across it.
    let longer = max(length(cross(grad_x, toward)), length(cross(grad_y, toward)));
    let det_ray = abs(dot(across, toward));
    // det = 0 means that the matrix does not belong to this light; a texel then has no size to speak of.
    let texel = select(0.0, longer / det_ray, det_ray > 0.0);
    let shift = lookup.bias_world + lookup.bias_texels * texel;
    // The row's product with the moved point, as a change of its product with the point.
    let w_moved = w + shift * dot(m.row_w.xyz, toward);
    if !(w_moved > 0.0) {
        return LIT;
    }
    // z_moved / w_moved = ndc.z + shift * (row_z - ndc.z row_w) . toward / w_moved: nothing cancels.
    var z = ndc.z + shift * dot(grad_z, toward) * (w / w_moved) - lookup.bias_ndc;

    // Part 2: what the receiver's own plane gains over the filter's reach.
    if lookup.slope > 0.0 {
        let det = abs(dot(across, normal));
        let gain = abs(dot(grad_z, cross(grad_y, normal))) + abs(dot(grad_z, cross(grad_x, normal)));
        let reach = select(0.5, 1.0, lookup.filter_kind == 1);
        var limit = BOUNDLESS;
        if lookup.slope_limit < BOUNDLESS {
            limit = lookup.slope_limit * texel * abs(dot(grad_z, toward));
        }
        // A plane seen edge on (det = 0) has no finite slope in the map: the limit alone holds it.
        z -= min(select(BOUNDLESS, lookup.slope * reach * gain / det, det > 0.0), limit);
    }
    // Beyond the far plane casters are all nearer, and an empty texel stores 1. No bias takes a receiver out of the map's
    // depth: nearer than the near plane is what lies there itself.
    return Comparison(uv * size, clamp(z, 0.0, 1.0), false);
}

// 1 where the stored depth is at least z. Clamp to edge.
fn lit(map: u32, texel: vec2i, z: f32) -> f32 {
    let inside = clamp(texel, vec2i(0), vec2i(textureDimensions(depth_maps)) - 1);
    return select(0.0, 1.0, textureLoad(depth_maps, inside, map, 0) >= z);
}

fn light(map: u32, p: vec3f, normal: vec3f) -> f32 {
    let at = compare_at(maps[map], p, normal);
    if at.is_lit {
        return 1.0;
    }
    if lookup.filter_kind == 0 {
        return lit(map, vec2i(floor(at.p_texel)), at.z);
    }
    let corner = floor(at.p_texel - 0.5);
    let f = at.p_texel - 0.5 - corner;
    let texel = vec2i(corner);
    let top = (1.0 - f.x) * lit(map, texel, at.z) + f.x * lit(map, texel + vec2i(1, 0), at.z);
    let bottom = (1.0 - f.x) * lit(map, texel + vec2i(0, 1), at.z) + f.x * lit(map, texel + vec2i(1, 1), at.z);
    return (1.0 - f.y) * top + f.y * bottom;
}

@compute @workgroup_size(8, 8)
fn shadow_mask(@builtin(global_invocation_id) invocation: vec3u) {
    let pixel = pixel_of(invocation);
    if pixel.z == 0 {
        return;
    }
    let id = textureLoad(ids, pixel.xy, 0).xy;
    if !is_mine(id) {
        return;
    }
    let i = invocation.y * view.width + invocation.x;
    if id.x == 0 {
        result[i] = -1.0;
        return;
    }
    let s = surface(pixel.xy, id);
    if faces_light(s.p_eye, s.normal) {
        result[i] = light(map_at(s.depth), s.p_eye, s.normal);
    } else {
        result[i] = 0.0;
    }
}
