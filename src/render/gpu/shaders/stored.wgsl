// What is stored of each texel, from the depths that its ray meets; twin of cpu/stored.rs and of Encoder in stored/encoder.rs.
//
// Space "place": NDC x and y of a texel's centre. Depths that are drawn are reversed, 1 at the near and 0 at the far plane,
// but for those that are stored as they are.
// Group 0: 0 settings, 1 first depths, 2 second depths.

struct Settings {
    // Linear depth over w, and 1 / w, at the far and at the near plane: affine functions of the place that are positive all over
    // the map. In x the least value, at a corner; in y and z what is gained to the right and down. Sums of what is not
    // negative cancel nothing.
    far_depth: vec4f,
    near_depth: vec4f,
    far_w: vec4f,
    near_w: vec4f,
    // Columns of local space from NDC, about the middle of the map and in units of its size: x and y times the step of a
    // texel, z, and 1.
    column_x: vec4f,
    column_y: vec4f,
    column_z: vec4f,
    column_1: vec4f,
    size: vec2f,
    // Largest share of the way between two depths: dual layers' in texels.
    limit: f32,
    unused: f32,
}

// Constants of a pipeline, not uniforms: see pipelines.rs.
// PLAIN, FRONT, SECOND, MIDPOINT or DUAL.
override surface: u32;
// 0: projective. 1: linear.
override spacing: u32;
// FLOAT, HALF, or the largest whole number of a normalised integer.
override format: u32;

@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var first: texture_depth_2d;
@group(0) @binding(2) var second: texture_depth_2d;

const PLAIN = 0u;
const FRONT = 1u;
const SECOND = 2u;
const MIDPOINT = 3u;
const DUAL = 4u;

const FLOAT = 0u;
const HALF = 1u;

// Stands for infinity, which WGSL need not know.
const BOUNDLESS = 1e30;

// `share` of the way to the right and down the map.
fn affine(f: vec4f, share: vec2f) -> f32 {
    return f.x + dot(abs(f.yz), select(1.0 - share, share, f.yz >= vec2f()));
}

// A point of the ray of a texel.
fn point(ndc: vec2f, depth: f32) -> vec4f {
    let p = settings.column_x * (0.5 * settings.size.x * ndc.x) + settings.column_y * (0.5 * settings.size.y * ndc.y);
    return p + settings.column_z * (1.0 - depth) + settings.column_1;
}

// World size of a texel across the ray, its longer side.
fn texel_size(p: vec4f) -> f32 {
    let at = p.xyz / p.w;
    let ray = settings.column_z.xyz - settings.column_z.w * at;
    let along_x = settings.column_x.xyz - settings.column_x.w * at;
    let along_y = settings.column_y.xyz - settings.column_y.w * at;
    return max(length(cross(along_x, ray)), length(cross(along_y, ray))) / (length(ray) * p.w);
}

struct Ray {
    ndc: vec2f,
    // Linear depth over w, and 1 / w, at the far and at the near plane.
    depth: vec2f,
    w: vec2f,
}

fn linear_depth(ray: Ray, z: f32) -> f32 {
    // Not mix(), whose rounding may cancel.
    return (ray.depth.x * (1.0 - z) + ray.depth.y * z) / (ray.w.x * (1.0 - z) + ray.w.y * z);
}

// The share of the way from one depth to another along the ray that dual layers go.
fn dual_share(ray: Ray, start: f32, to: f32, most: f32) -> f32 {
    let p = point(ray.ndc, start);
    let q = point(ray.ndc, to);
    let way = distance(p.xyz / p.w, q.xyz / q.w);
    return min(most, select(BOUNDLESS, settings.limit * texel_size(p) / way, way > 0.0));
}

// Depth in the units of what is stored.
fn value(texel: vec2f, z: vec2f) -> f32 {
    let share = (texel + 0.5) / settings.size;
    let ray = Ray(
        vec2f(2.0, -2.0) * share + vec2f(-1.0, 1.0),
        vec2f(affine(settings.far_depth, share), affine(settings.near_depth, share)),
        vec2f(affine(settings.far_w, share), affine(settings.near_w, share)),
    );
    let is_alone = z.y <= 0.0;
    var to = z.y;
    var part = 0.0;
    if surface == SECOND {
        part = 1.0;
    } else if surface == MIDPOINT {
        part = 0.5;
    } else if surface == DUAL {
        // A ray without a second depth goes towards the far plane.
        to = select(z.y, 0.0, is_alone);
        part = dual_share(ray, z.x, to, select(0.5, BOUNDLESS, is_alone));
    }
    if is_alone && (surface == SECOND || surface == MIDPOINT) {
        return 1.0;
    }
    if spacing == 1 {
        let start = linear_depth(ray, z.x);
        if part == 0.0 {
            return start;
        }
        return start + part * (linear_depth(ray, to) - start);
    }
    if part >= 1.0 {
        return select(1.0 - to, 1.0, surface == DUAL);
    }
    // w is an affine function of the way along the ray, and depth one of 1 / w.
    let w = vec2f(ray.w.x * (1.0 - z.x) + ray.w.y * z.x, ray.w.x * (1.0 - to) + ray.w.y * to);
    return 1.0 - (z.x * ((1.0 - part) * w.y) + to * (part * w.x)) / ((1.0 - part) * w.y + part * w.x);
}

// The nearest number of the format: Format::quantise.
fn quantised(z: f32) -> f32 {
    if format == FLOAT {
        return z;
    }
    if format == HALF {
        // Powers of two: nothing is rounded but the quotient, halves to even.
        let exponent = max(i32(bitcast<u32>(z) >> 23) - 127, -14);
        return ldexp(round(ldexp(z, 10 - exponent)), exponent - 10);
    }
    let levels = f32(format);
    return round(z * levels) / levels;
}

@vertex
fn everything(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    // One triangle over the whole map.
    return vec4f(f32(i32(i & 1) * 4 - 1), f32(i32(i >> 1) * 4 - 1), 0.0, 1.0);
}

@fragment
fn stored(@builtin(position) p: vec4f) -> @builtin(frag_depth) f32 {
    let texel = vec2i(p.xy);
    let z = vec2f(textureLoad(first, texel, 0), textureLoad(second, texel, 0));
    if surface == PLAIN {
        return quantised(z.x);
    }
    if z.x <= 0.0 {
        return 1.0;
    }
    return quantised(clamp(value(vec2f(texel), z), 0.0, 1.0));
}
