// The light that arrives at each pixel through the shadow maps; twin of cpu/lookup/lookup.rs; surface.wgsl and choose.wgsl come
// before this text, filter.wgsl after it.
//
// Numbers: the place in the map, its gradients and the biased depth are `real` of single.wgsl or double.wgsl. Of the place a texel
// and the way within it are left in the end, so that weights keep their digits in single precision, wherever in the map they are.
// Space: "eye" of surface.wgsl, lengths in its unit. Space "texel": the map in texels, x to the right, y down.
// Group 1, beside choose.wgsl's: 2 bias, blending, batch and filter, 3 the maps of this batch, 4 result: for the n pixels of the
// rows at hand n values in [0, 1], -1 where nothing is, then the index of the map that each asks, NO_MAP for none. The value of a pixel is the sum of those of all batches; one that no map of this batch lights has OTHER_BATCH, and a value
// that says nothing.

// Constants of a pipeline.
// NEAREST, BILINEAR, BOX, TENT or DISC of filter.wgsl.
override filter_kind: u32;
// Whether texels are compared with the receiver's own plane.
override compares_plane: bool;

struct Lookup {
    bias_world: f32,
    bias_texels: f32,
    bias_ndc: f32,
    slope: f32,
    slope_limit: f32,
    plane: f32,
    bias_normal: f32,
    // The last share of each map's range over which the next map is mixed in.
    blend: f32,
    // The maps of this batch.
    first_map: u32,
    end_map: u32,
    // Polygon offset: of a normalised format units times its step, else units and the binary digits of a float's step.
    factor: f32,
    units: f32,
    digits: i32,
    unused_0: u32,
    unused_1: u32,
    unused_2: u32,
    // See filter.wgsl.
    kernel: Kernel,
}

@group(1) @binding(2) var<storage, read> lookup: Lookup;
@group(1) @binding(3) var depth_maps: texture_depth_2d_array;
@group(1) @binding(4) var<storage, read_write> result: array<u32>;

const OTHER_BATCH = 0xfffffffeu;

// Larger than any bias that leaves a depth in [0, 1]; stands for infinity, which WGSL need not know.
const BOUNDLESS = 1e30;

struct Comparison {
    // The texel that the place is in, and the way from its corner, 0 to 1.
    texel: vec2i,
    within: vec2f,
    // The texels about it that are compared.
    shape: Shape,
    // Biased, but for the part that each texel has of its own: depth on the receiver's plane by texel, by what it is divided there,
    // and how much it may change.
    z: f32,
    per_texel: vec2f,
    divisor: vec2f,
    limit: f32,
    // Lit without a look at the map: outside of it, behind its projection centre, or nearer than its near plane.
    is_lit: bool,
}

// A receiver in a map, with how what it is there changes about it.
struct Projected {
    is_within: bool,
    w: real,
    ndc: real3,
    // In the map, texels.
    place: real2,
    // Depth in the units of what is stored, and what it is divided by: NDC z and w where that is projective.
    depth: real,
    denominator: real,
    // Gradients of the texel coordinates X and Y (down), and of that depth.
    grad_x: real3,
    grad_y: real3,
    grad_z: real3,
    // The relative gradient of what depth on a plane is divided by; zero where depth is projective.
    grad_divisor: real3,
    across: real3,
    det_ray: real,
    toward: real3,
    // World size of a texel across the ray.
    texel: real,
    // Gradients of w and of the denominator.
    grad_w: real3,
    grad_denominator: real3,
}

fn to_light(p: real3) -> real3 {
    let v = real3(choice.light.xyz) - real(choice.light.w) * p;
    let size = length(v);
    return select(real3(), v / size, size > 0.0);
}

fn projected(m: Map, p: real3) -> Projected {
    var at: Projected;
    let p4 = real4(p, 1.0);
    let row_x = whole4(array<vec4f, 2>(m.row_x, m.row_x_low));
    let row_y = whole4(array<vec4f, 2>(m.row_y, m.row_y_low));
    let row_z = whole4(array<vec4f, 2>(m.row_z, m.row_z_low));
    let row_w = whole4(array<vec4f, 2>(m.row_w, m.row_w_low));
    let numerator = whole4(array<vec4f, 2>(m.depth_numerator, m.depth_numerator_low));
    let denominator = whole4(array<vec4f, 2>(m.depth_denominator, m.depth_denominator_low));
    at.w = dot(row_w, p4);
    if !(at.w > 0.0) {
        return at;
    }
    at.ndc = real3(dot(row_x, p4), dot(row_y, p4), dot(row_z, p4)) / at.w;
    let uv = real2(0.5 + 0.5 * at.ndc.x, 0.5 - 0.5 * at.ndc.y);
    at.is_within = at.ndc.z >= 0.0 && uv.x >= 0.0 && uv.x <= 1.0 && uv.y >= 0.0 && uv.y <= 1.0;
    let size = real2(vec2f(textureDimensions(depth_maps)));
    at.place = uv * size;
    at.grad_x = 0.5 * size.x * (row_x.xyz - at.ndc.x * row_w.xyz) / at.w;
    at.grad_y = -0.5 * size.y * (row_y.xyz - at.ndc.y * row_w.xyz) / at.w;
    at.denominator = dot(denominator, p4);
    at.depth = dot(numerator, p4) / at.denominator;
    at.grad_z = (numerator.xyz - at.depth * denominator.xyz) / at.denominator;
    at.grad_divisor = denominator.xyz / at.denominator - row_w.xyz / at.w;
    at.grad_w = row_w.xyz;
    at.grad_denominator = denominator.xyz;
    at.across = cross(at.grad_x, at.grad_y);
    at.toward = to_light(p);
    let longer = max(length(cross(at.grad_x, at.toward)), length(cross(at.grad_y, at.toward)));
    at.det_ray = abs(dot(at.across, at.toward));
    // det = 0 means that the matrix does not belong to this light; a texel then has no size to speak of.
    at.texel = select(real(0.0), longer / at.det_ray, at.det_ray > 0.0);
    return at;
}

// A receiver: as a G-buffer stores it, so that it is the same one as in a look-up of that. G-buffers have single precision about
// the scene's origin; where that is all there is, another rounding would only add to those about the eye.
fn stored_position(p_eye: real3) -> real3 {
    if !IS_DOUBLE {
        return p_eye;
    }
    let p_stored = vec3f(real(view.unit) * p_eye + eye_minus_origin());
    return (real3(p_stored) - eye_minus_origin()) / real(view.unit);
}

fn compare_at(m: Map, p_eye: real3, normal: real3) -> Comparison {
    var p = p_eye;
    var at = projected(m, p);
    if at.is_within && lookup.bias_normal != 0.0 {
        p += real(lookup.bias_normal) * at.texel * normal;
        at = projected(m, p);
    }
    var unread: Comparison;
    unread.is_lit = true;
    if !at.is_within {
        return unread;
    }

    // Part 1: along the ray, by the world size of a texel across it.
    let shift = real(lookup.bias_world) + real(lookup.bias_texels) * at.texel;
    // The row's product with the moved point, as a change of its product with the point.
    let w_moved = at.w + shift * dot(at.grad_w, at.toward);
    if !(w_moved > 0.0) {
        return unread;
    }
    let denominator_moved = at.denominator + shift * dot(at.grad_denominator, at.toward);
    // z_moved / w_moved = ndc.z + shift * (row_z - ndc.z row_w) . toward / w_moved: nothing cancels.
    var z = at.depth + shift * dot(at.grad_z, at.toward) * (at.denominator / denominator_moved);
    z -= real(lookup.bias_ndc);

    let shape = shape_at(p, normal, at.grad_x, at.grad_y);

    // Part 2: what the receiver's own plane gains over the filter's reach, and at each texel.
    var per_texel = vec2f();
    var divisor = vec2f();
    var limit = BOUNDLESS;
    if lookup.slope > 0.0 || compares_plane || lookup.factor != 0.0 {
        let facing = dot(at.across, normal);
        let change = real2(dot(at.grad_z, cross(at.grad_y, normal)), -dot(at.grad_z, cross(at.grad_x, normal)));
        let reach = lookup.slope * shape.reach;
        if lookup.slope_limit < BOUNDLESS {
            // What a surface straight across the ray gains, by the change of w alone, carries nothing along the ray.
            let gain_across =
                abs(real2(dot(at.grad_z, cross(at.grad_y, at.toward)), dot(at.grad_z, cross(at.grad_x, at.toward))));
            let due = select(real(0.0), dot(real2(reach), gain_across) / at.det_ray, at.det_ray > 0.0);
            limit = f32(real(lookup.slope_limit) * at.texel * abs(dot(at.grad_z, at.toward)) + due);
        }
        // A plane seen edge on (facing = 0) has no finite slope in the map: the limit alone holds it.
        if facing != 0.0 {
            per_texel = vec2f(change / facing);
            let g = at.grad_divisor;
            divisor = vec2f(real2(dot(g, cross(at.grad_y, normal)), -dot(g, cross(at.grad_x, normal))) / facing);
        }
        if lookup.slope > 0.0 {
            let due = lookup.slope * fall(per_texel, divisor, shape.reach);
            z -= real(min(select(BOUNDLESS, due, facing != 0.0), limit));
        }
        if lookup.factor != 0.0 {
            let steepest = select(BOUNDLESS, max(abs(per_texel.x), abs(per_texel.y)), facing != 0.0);
            z -= real(clamp(lookup.factor * steepest, -limit, limit));
        }
    }
    if lookup.units != 0.0 {
        // A float in [2^(e - 1), 2^e) has the step 2^(e - 1 - digits).
        let exponent = select(0, frexp(clamp(f32(at.depth), 1e-30, 1.0)).exp - 1 - lookup.digits, lookup.digits > 0);
        z -= real(ldexp(lookup.units, exponent));
    }
    let corner = floor(at.place);
    return Comparison(vec2i(corner), vec2f(at.place - corner), shape, f32(z), per_texel, divisor, limit, false);
}

// How much farther a plane is so many texels away.
fn plane_change(per_texel: vec2f, divisor: vec2f, texels: vec2f) -> f32 {
    let over = 1.0 + dot(divisor, texels);
    return select(-BOUNDLESS, dot(per_texel, texels) / over, over > 0.0);
}

// How much depth falls at most on a plane within a reach: a quotient of affine functions is least at a corner.
fn fall(per_texel: vec2f, divisor: vec2f, reach: vec2f) -> f32 {
    let falls = vec4f(
        plane_change(per_texel, divisor, reach),
        plane_change(per_texel, divisor, vec2f(reach.x, -reach.y)),
        plane_change(per_texel, divisor, vec2f(-reach.x, reach.y)),
        plane_change(per_texel, divisor, -reach),
    );
    return max(0.0, -min(min(falls.x, falls.y), min(falls.z, falls.w)));
}

// 1 where the stored depth of a layer is at least that of the receiver at a texel. Clamp to edge.
fn lit(layer: u32, texel: vec2i, at: Comparison) -> f32 {
    var z = at.z;
    if compares_plane {
        // The depth of the receiver's plane at the texel's centre.
        let change = plane_change(at.per_texel, at.divisor, vec2f(texel - at.texel) + 0.5 - at.within);
        z += lookup.plane * clamp(change, -at.limit, at.limit);
    }
    // Beyond the far plane casters are all nearer, and an empty texel stores 1. No bias takes a receiver out of the map's
    // depth: nearer than the near plane is what lies there itself.
    z = clamp(z, 0.0, 1.0);
    let inside = clamp(texel, vec2i(0), vec2i(textureDimensions(depth_maps)) - 1);
    return select(0.0, 1.0, textureLoad(depth_maps, inside, layer, 0) >= z);
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
    let p = vec3f(s.p_eye);
    let depth = f32(s.depth);
    let normal = vec3f(s.normal);
    if !faces_light(p, normal) {
        write(invocation, 0.0, NO_MAP);
        return;
    }
    let map = choose(p, depth);
    if map == NO_MAP {
        write(invocation, 1.0, NO_MAP);
        return;
    }
    let next = next_map(map, p, depth);
    let is_here = is_in_batch(map);
    let is_next_here = next.share > 0.0 && is_in_batch(next.map);
    if !is_here && !is_next_here {
        write(invocation, 0.0, OTHER_BATCH);
        return;
    }
    let receiver = stored_position(s.p_eye);
    var value = 0.0;
    if is_here {
        value += (1.0 - next.share) * light(map, receiver, real3(normal));
    }
    if is_next_here {
        value += next.share * light(next.map, receiver, real3(normal));
    }
    write(invocation, value, map);
}

fn is_in_batch(map: u32) -> bool {
    return map >= lookup.first_map && map < lookup.end_map;
}

// A map whose light is mixed in, and its share.
struct Next {
    map: u32,
    share: f32,
}

// The map that would serve a receiver beyond the range of the one that does; twin of cpu/lookup/blending.rs.
fn next_map(k: u32, p: vec3f, depth: f32) -> Next {
    let none = Next(NO_MAP, 0.0);
    if lookup.blend == 0.0 {
        return none;
    }
    var share = 0.0;
    var first = k + 1;
    if choice.selection == 0 {
        let end = maps[k].depth_end;
        if end >= ENDLESS {
            return none;
        }
        let zone = lookup.blend * (end - maps[k].depth_begin);
        share = (depth - (end - zone)) / zone;
        first = 0u;
        while first < choice.maps && !(maps[first].depth_end > end) {
            first++;
        }
    } else {
        let ndc = abs(ndc_in(k, p).xy);
        share = (max(ndc.x, ndc.y) - (1.0 - lookup.blend)) / lookup.blend;
    }
    // Written so that a NaN, of a range without a beginning, is none.
    if !(share > 0.0) {
        return none;
    }
    let found = first_that_holds(first, p);
    if found == NO_MAP || found == k {
        return none;
    }
    return Next(found, min(share, 1.0));
}
