// Whether light could arrive at a receiver, and the map that serves it; twin of Light::illuminates and of
// Parameterization::choose; surface.wgsl comes before this text.
//
// Space: "eye" of surface.wgsl, lengths in its unit.
// Group 1: 0 the light and how maps are chosen, 1 one record a map. Part of lookup.wgsl and footprint.wgsl, which number
// their own resources from 2.

struct Choice {
    // The light's centre: (unit vector to the light, 0) or (position, 1).
    light: vec4f,
    // Of a spot: its unit axis, and the cosine of half its cone's angle; -2 without a cone.
    cone: vec4f,
    range: f32,
    maps: u32,
    // 0: by camera depth. 1: by containment.
    selection: u32,
    unused: u32,
}

struct Map {
    // Rows of shadow_clip_from_eye, all times one power of two.
    row_x: vec4f,
    row_y: vec4f,
    row_z: vec4f,
    row_w: vec4f,
    // Functionals that are not negative on the rays this map serves; zero for none.
    region: array<vec4f, 8>,
    // How the texel's coordinates change about a point: see footprint.wgsl.
    gradient_x: Gradient,
    gradient_y: Gradient,
    ray: vec4f,
    texel: vec3f,
    // The last camera depth this map serves; ENDLESS where it serves all beyond.
    depth_end: f32,
    regions: u32,
    // 0: none. 1: NDC y is log_scale ln w + log_offset, w that of the row here, its power of two included.
    post_warp: u32,
    log_scale: f32,
    log_offset: f32,
    // The first camera depth of its range.
    depth_begin: f32,
    unused_0: u32,
    unused_1: u32,
    unused_2: u32,
    // What stored depths measure: this times (p, 1), over that times (p, 1).
    depth_numerator: vec4f,
    depth_denominator: vec4f,
    // What single precision leaves of the four rows and of these two.
    row_x_low: vec4f,
    row_y_low: vec4f,
    row_z_low: vec4f,
    row_w_low: vec4f,
    depth_numerator_low: vec4f,
    depth_denominator_low: vec4f,
}

struct Gradient {
    at_eye: vec3f,
    turn: vec3f,
}

@group(1) @binding(0) var<storage, read> choice: Choice;
@group(1) @binding(1) var<storage, read> maps: array<Map>;

const NO_MAP = 0xffffffffu;

// The largest number: a range without an end.
const ENDLESS = 3.4028234e38;

// Of a functional of a region, relative to its terms: the roundings of its coefficients, of the point and of the sum, 2^-24
// each. A point on the border between two maps must not fall between them.
const REGION_ROUNDING = 16.0 / 16777216.0;

// scene::EDGE_ON.
const EDGE_ON = 4.0 / 8388608.0;

// Whether light could arrive: the normal is turned towards the light, and the point is within its cone and range.
fn faces_light(p: vec3f, normal: vec3f) -> bool {
    let v = choice.light.xyz - choice.light.w * p;
    let distance = length(v);
    // Of a placed light the difference errs by roundings of both places: a lamp in the plane of a wall is edge-on to it
    // however near it is.
    let reach = distance + choice.light.w * dot(abs(normal), abs(p) + abs(choice.light.xyz));
    if !(dot(normal, v) > EDGE_ON * reach) {
        return false;
    }
    if choice.light.w == 0.0 {
        return true;
    }
    return distance <= choice.range && (choice.cone.w < -1.0 || dot(-v, choice.cone.xyz) >= distance * choice.cone.w);
}

// NDC of a point in a map; meaningful where its w is above 0.
fn ndc_in(k: u32, p: vec3f) -> vec3f {
    let p4 = vec4f(p, 1.0);
    let w = dot(maps[k].row_w, p4);
    var ndc = vec3f(dot(maps[k].row_x, p4), dot(maps[k].row_y, p4), dot(maps[k].row_z, p4)) / w;
    if maps[k].post_warp == 1 {
        ndc.y = maps[k].log_scale * log(w) + maps[k].log_offset;
    }
    return ndc;
}

const OUTSIDE = 0;
const BEYOND = 1;
const WITHIN = 2;

// How a map holds a point: Held of parameterization.rs.
fn holds(k: u32, p: vec3f) -> i32 {
    let p4 = vec4f(p, 1.0);
    for (var i = 0u; i < maps[k].regions; i++) {
        let f = maps[k].region[i];
        if !(dot(f, p4) >= -REGION_ROUNDING * dot(abs(f), abs(p4))) {
            return OUTSIDE;
        }
    }
    if !(dot(maps[k].row_w, p4) > 0.0) {
        return OUTSIDE;
    }
    let ndc = ndc_in(k, p);
    if !(abs(ndc.x) <= 1.0 && abs(ndc.y) <= 1.0) {
        return OUTSIDE;
    }
    return select(BEYOND, WITHIN, ndc.z <= 1.0);
}

// The map that serves a receiver, or NO_MAP: Parameterization::choose.
fn choose(p: vec3f, depth: f32) -> u32 {
    var k = 0u;
    if choice.selection == 0 {
        while k + 1 < choice.maps && !(depth <= maps[k].depth_end) {
            k++;
        }
    }
    return first_that_holds(k, p);
}

// The first map from one on that a point is within, else the first that it is beyond, or NO_MAP: Held::first.
fn first_that_holds(first: u32, p: vec3f) -> u32 {
    var found = NO_MAP;
    for (var k = first; k < choice.maps; k++) {
        let held = holds(k, p);
        if held == WITHIN {
            return k;
        }
        if held == BEYOND && found == NO_MAP {
            found = k;
        }
    }
    return found;
}
