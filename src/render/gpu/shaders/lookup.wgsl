// The light that arrives at each pixel through the shadow maps; twin of cpu/lookup/lookup.rs; surface.wgsl and choose.wgsl come
// before this text.
//
// Space: "eye" of surface.wgsl, lengths in its unit. Space "texel": the map in texels, x to the right, y down.
// Group 1, beside choose.wgsl's: 2 bias, filter and batch, 3 the maps of this batch, 4 result: for the n pixels of the rows
// at hand n values in [0, 1], -1 where nothing is, then the index of the map that each asks, NO_MAP for none; a pixel that
// asks a map of another batch has OTHER_BATCH, and a value that says nothing.

struct Lookup {
    bias_world: f32,
    bias_texels: f32,
    bias_ndc: f32,
    slope: f32,
    slope_limit: f32,
    plane: f32,
    bias_normal: f32,
    // 0: one comparison with the texel the point falls into. 1: bilinear weights over the four nearest.
    filter_kind: u32,
    // The maps of this batch.
    first_map: u32,
    end_map: u32,
    unused_0: u32,
    unused_1: u32,
}

@group(1) @binding(2) var<uniform> lookup: Lookup;
@group(1) @binding(3) var depth_maps: texture_depth_2d_array;
@group(1) @binding(4) var<storage, read_write> result: array<u32>;

const OTHER_BATCH = 0xfffffffeu;

// Larger than any bias that leaves a depth in [0, 1]; stands for infinity, which WGSL need not know.
const BOUNDLESS = 1e30;

struct Comparison {
    p_texel: vec2f,
    // Biased, but for the part that each texel has of its own: depth on the receiver's plane by texel, by what it is divided there,
    // and how much it may change.
    z: f32,
    per_texel: vec2f,
    divisor: vec2f,
    limit: f32,
    // Lit without a look at the map: outside of it, behind its projection centre, or nearer than its near plane.
    is_lit: bool,
}

const LIT = Comparison(vec2f(), 0.0, vec2f(), vec2f(), 0.0, true);

// A receiver in a map, with how what it is there changes about it.
struct Projected {
    is_within: bool,
    w: f32,
    ndc: vec3f,
    // In the map, texels.
    place: vec2f,
    // Depth in the units of what is stored, and what it is divided by: NDC z and w where that is projective.
    depth: f32,
    denominator: f32,
    // Gradients of the texel coordinates X and Y (down), and of that depth.
    grad_x: vec3f,
    grad_y: vec3f,
    grad_z: vec3f,
    // The relative gradient of what depth on a plane is divided by; zero where depth is projective.
    grad_divisor: vec3f,
    across: vec3f,
    det_ray: f32,
    toward: vec3f,
    // World size of a texel across the ray.
    texel: f32,
}

fn to_light(p: vec3f) -> vec3f {
    let v = choice.light.xyz - choice.light.w * p;
    let size = length(v);
    return select(vec3f(), v / size, size > 0.0);
}

fn projected(m: Map, p: vec3f) -> Projected {
    var at: Projected;
    let p4 = vec4f(p, 1.0);
    at.w = dot(m.row_w, p4);
    if !(at.w > 0.0) {
        return at;
    }
    at.ndc = vec3f(dot(m.row_x, p4), dot(m.row_y, p4), dot(m.row_z, p4)) / at.w;
    let uv = vec2f(0.5 + 0.5 * at.ndc.x, 0.5 - 0.5 * at.ndc.y);
    at.is_within = at.ndc.z >= 0.0 && uv.x >= 0.0 && uv.x <= 1.0 && uv.y >= 0.0 && uv.y <= 1.0;
    let size = vec2f(textureDimensions(depth_maps));
    at.place = uv * size;
    at.grad_x = 0.5 * size.x * (m.row_x.xyz - at.ndc.x * m.row_w.xyz) / at.w;
    at.grad_y = -0.5 * size.y * (m.row_y.xyz - at.ndc.y * m.row_w.xyz) / at.w;
    at.denominator = dot(m.depth_denominator, p4);
    at.depth = dot(m.depth_numerator, p4) / at.denominator;
    at.grad_z = (m.depth_numerator.xyz - at.depth * m.depth_denominator.xyz) / at.denominator;
    at.grad_divisor = m.depth_denominator.xyz / at.denominator - m.row_w.xyz / at.w;
    at.across = cross(at.grad_x, at.grad_y);
    at.toward = to_light(p);
    let longer = max(length(cross(at.grad_x, at.toward)), length(cross(at.grad_y, at.toward)));
    at.det_ray = abs(dot(at.across, at.toward));
    // det = 0 means that the matrix does not belong to this light; a texel then has no size to speak of.
    at.texel = select(0.0, longer / at.det_ray, at.det_ray > 0.0);
    return at;
}

fn compare_at(m: Map, p: vec3f, normal: vec3f) -> Comparison {
    var at = projected(m, p);
    if at.is_within && lookup.bias_normal != 0.0 {
        at = projected(m, p + lookup.bias_normal * at.texel * normal);
    }
    if !at.is_within {
        return LIT;
    }

    // Part 1: along the ray, by the world size of a texel across it.
    let shift = lookup.bias_world + lookup.bias_texels * at.texel;
    // The row's product with the moved point, as a change of its product with the point.
    let w_moved = at.w + shift * dot(m.row_w.xyz, at.toward);
    if !(w_moved > 0.0) {
        return LIT;
    }
    let denominator_moved = at.denominator + shift * dot(m.depth_denominator.xyz, at.toward);
    // z_moved / w_moved = ndc.z + shift * (row_z - ndc.z row_w) . toward / w_moved: nothing cancels.
    var z = at.depth + shift * dot(at.grad_z, at.toward) * (at.denominator / denominator_moved) - lookup.bias_ndc;

    // Part 2: what the receiver's own plane gains over the filter's reach, and at each texel.
    var per_texel = vec2f();
    var divisor = vec2f();
    var limit = BOUNDLESS;
    if lookup.slope > 0.0 || lookup.plane > 0.0 {
        let facing = dot(at.across, normal);
        let change = vec2f(dot(at.grad_z, cross(at.grad_y, normal)), -dot(at.grad_z, cross(at.grad_x, normal)));
        let reach = lookup.slope * select(0.5, 1.0, lookup.filter_kind == 1);
        if lookup.slope_limit < BOUNDLESS {
            // What a surface straight across the ray gains, by the change of w alone, carries nothing along the ray.
            let gain_across =
                abs(dot(at.grad_z, cross(at.grad_y, at.toward))) + abs(dot(at.grad_z, cross(at.grad_x, at.toward)));
            let due = select(0.0, reach * gain_across / at.det_ray, at.det_ray > 0.0);
            limit = lookup.slope_limit * at.texel * abs(dot(at.grad_z, at.toward)) + due;
        }
        // A plane seen edge on (facing = 0) has no finite slope in the map: the limit alone holds it.
        if facing != 0.0 {
            per_texel = change / facing;
            let g = at.grad_divisor;
            divisor = vec2f(dot(g, cross(at.grad_y, normal)), -dot(g, cross(at.grad_x, normal))) / facing;
        }
        if lookup.slope > 0.0 {
            let reach_texels = select(0.5, 1.0, lookup.filter_kind == 1);
            z -= min(select(BOUNDLESS, lookup.slope * fall(per_texel, divisor, reach_texels), facing != 0.0), limit);
        }
    }
    return Comparison(at.place, z, per_texel, divisor, limit, false);
}

// How much farther a plane is so many texels away.
fn plane_change(per_texel: vec2f, divisor: vec2f, texels: vec2f) -> f32 {
    let over = 1.0 + dot(divisor, texels);
    return select(-BOUNDLESS, dot(per_texel, texels) / over, over > 0.0);
}

// How much depth falls at most on a plane within a reach: a quotient of affine functions is least at a corner.
fn fall(per_texel: vec2f, divisor: vec2f, reach: f32) -> f32 {
    let r = vec2f(reach, -reach);
    let falls = vec4f(
        plane_change(per_texel, divisor, r.xx),
        plane_change(per_texel, divisor, r.xy),
        plane_change(per_texel, divisor, r.yx),
        plane_change(per_texel, divisor, r.yy),
    );
    return max(0.0, -min(min(falls.x, falls.y), min(falls.z, falls.w)));
}

// 1 where the stored depth of a layer is at least that of the receiver at a texel. Clamp to edge.
fn lit(layer: u32, texel: vec2i, at: Comparison) -> f32 {
    var z = at.z;
    if lookup.plane > 0.0 {
        // The depth of the receiver's plane at the texel's centre.
        let change = plane_change(at.per_texel, at.divisor, vec2f(texel) + 0.5 - at.p_texel);
        z += lookup.plane * clamp(change, -at.limit, at.limit);
    }
    // Beyond the far plane casters are all nearer, and an empty texel stores 1. No bias takes a receiver out of the map's
    // depth: nearer than the near plane is what lies there itself.
    z = clamp(z, 0.0, 1.0);
    let inside = clamp(texel, vec2i(0), vec2i(textureDimensions(depth_maps)) - 1);
    return select(0.0, 1.0, textureLoad(depth_maps, inside, layer, 0) >= z);
}

fn light(map: u32, p: vec3f, normal: vec3f) -> f32 {
    let at = compare_at(maps[map], p, normal);
    let layer = map - lookup.first_map;
    if at.is_lit {
        return 1.0;
    }
    if lookup.filter_kind == 0 {
        return lit(layer, vec2i(floor(at.p_texel)), at);
    }
    let corner = floor(at.p_texel - 0.5);
    let f = at.p_texel - 0.5 - corner;
    let texel = vec2i(corner);
    let top = (1.0 - f.x) * lit(layer, texel, at) + f.x * lit(layer, texel + vec2i(1, 0), at);
    let bottom = (1.0 - f.x) * lit(layer, texel + vec2i(0, 1), at) + f.x * lit(layer, texel + vec2i(1, 1), at);
    return (1.0 - f.y) * top + f.y * bottom;
}

// The result of a pixel: its light and the map it asked.
fn write(invocation: vec3u, value: f32, map: u32) {
    let i = invocation.y * view.width + invocation.x;
    result[i] = bitcast<u32>(value);
    result[view.width * view.rows + i] = map;
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
    if id.x == 0 {
        write(invocation, -1.0, NO_MAP);
        return;
    }
    let s = surface(pixel.xy, id);
    if !faces_light(s.p_eye, s.normal) {
        write(invocation, 0.0, NO_MAP);
        return;
    }
    let map = choose(s.p_eye, s.depth);
    if map == NO_MAP {
        write(invocation, 1.0, NO_MAP);
    } else if map < lookup.first_map || map >= lookup.end_map {
        write(invocation, 0.0, OTHER_BATCH);
    } else {
        write(invocation, light(map, s.p_eye, s.normal), map);
    }
}
