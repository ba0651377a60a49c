// What one texel of the shadow map looks like in the image at each pixel; twin of aliasing/footprint.rs and aliasing/texel.rs;
// surface.wgsl and choose.wgsl come before this text.
//
// Space: "eye" of surface.wgsl, lengths in its unit. Space "pixel": the image, x to the right, y down. Space "texel": the map.
// Group 1, beside choose.wgsl's: 2 result: for the n pixels of the rows at hand the planes of image::Footprint, n numbers each,
// then the index of each one's map, or NO_MAP, AVERTED or NOTHING; there the numbers have the bits of a NaN, of which WGSL
// knows nothing.
//
// The twin takes gradients from X, Y and w, where the rows of the map all but cancel under a strong warp. Here the host
// multiplies out, in double precision, what they are apart from powers of w. With X, W the rows, ' their gradients, 0 their
// last entries,
//
//     G_x = w X' - X W' = (W_0 X' - X_0 W') + p x (X' x W'),      gradient of NDC x = G_x / w^2
//     G_x x G_y = w R,    R = det(X', Y', W') p + W_0 X' x Y' + Y_0 W' x X' + X_0 Y' x W'
//
// and R is zero at the map's centre of projection alone. Under a logarithm (11.1) G_y = scale W', gradient of NDC y = G_y / w,
// R = scale X' x W'. A map stores G_x, G_y and R each times a power of two.
//
// A point where the map that serves it is singular has none.

@group(1) @binding(2) var<storage, read_write> result: array<u32>;

const PLANES = 10u;
const AVERTED = 0xfffffffeu;
const NOTHING = 0xfffffffdu;
const NAN_BITS = 0x7fc00000u;

// Square of the sum of two opposed unit vectors that is nothing but their roundings, four of 2^-24.
const OPPOSED = 16.0 / (16777216.0 * 16777216.0);

// Largest number of f32. Texels longer than that are those of a singular map.
const LARGEST = 3.4028234e38;

struct Texel {
    // Columns: the pixels of a step of one texel along x and along y.
    on_surface: mat2x2f,
    major: f32,
    perspective: f32,
    perspective_ts: vec2f,
    projection: f32,
}

fn larger_singular_value(m: mat2x2f) -> f32 {
    let sum = length(vec2f(m[0].x + m[1].y, m[1].x - m[0].y));
    let difference = length(vec2f(m[0].x - m[1].y, m[1].x + m[0].y));
    return 0.5 * (sum + difference);
}

fn gradient(g: Gradient, p: vec3f) -> vec3f {
    return g.at_eye + cross(p, g.turn);
}

// The texel of map k at a point; `ndc` is the pixel's place.
fn texel(k: u32, s: Surface, ndc: vec2f) -> Texel {
    let p = vec3f(s.p_eye);
    let normal = vec3f(s.normal);
    let w = dot(maps[k].row_w, vec4f(p, 1.0));
    let factor = vec2f(w * maps[k].texel.x, select(w, 1.0, maps[k].post_warp == 1) * maps[k].texel.y);
    let g_x = gradient(maps[k].gradient_x, p);
    let g_y = gradient(maps[k].gradient_y, p);
    let to_centre = maps[k].ray.w * p + maps[k].ray.xyz;
    let distance_to_centre = length(to_centre);
    let facing = dot(to_centre, normal);

    // Gradients of the pixel's coordinates. Its NDC are exact, so nothing of what is seen edge on cancels in them.
    let scale = 0.5 * vec2f(f32(view.width), -f32(view.height)) / f32(w_at(s.depth));
    let per_right = 1.0 / dot(view.right, view.right);
    let per_up = 1.0 / dot(view.up, view.up);
    // From the view axis; places of parallel rays do not move with depth.
    let turning = select(ndc + view.shift, vec2f(), view.rays == PARALLEL);
    let pixel_x = scale.x * (per_right * view.right - turning.x * view.forward);
    let pixel_y = scale.y * (per_up * view.up - turning.y * view.forward);

    var t: Texel;
    let step_x = (factor.x / facing) * cross(g_y, normal);
    let step_y = (factor.y / facing) * cross(normal, g_x);
    t.on_surface = mat2x2f(dot(pixel_x, step_x), dot(pixel_y, step_x), dot(pixel_x, step_y), dot(pixel_y, step_y));
    t.major = larger_singular_value(t.on_surface);

    // Unit ways from the eye and from the light; the light is on the side of the normal.
    let ray = vec3f(ray_through(real2(ndc)).direction);
    let ray_length = length(ray);
    let e = ray / ray_length;
    let d = to_centre * (select(1.0, -1.0, facing > 0.0) / distance_to_centre);
    // A step across the map's ray, mirrored at the plane that halves the angle between eye and light, has the pixels of the step
    // on that plane: they differ along e. Nothing is divided by a cosine, so eye and light may all but oppose each other;
    // where they do, the plane across e (theory.md E.2) leaves the step as it is.
    let back = e + d;
    let size = dot(back, back);
    let fold = select(0.0, 2.0 / size, size > OPPOSED) * back;
    let across_x = (factor.x / distance_to_centre) * cross(g_y, d);
    let across_y = (factor.y / distance_to_centre) * cross(d, g_x);
    let mirrored_x = across_x - dot(across_x, back) * fold;
    let mirrored_y = across_y - dot(across_y, back) * fold;
    t.perspective_ts = vec2f(
        length(vec2f(dot(pixel_x, mirrored_x), dot(pixel_y, mirrored_x))),
        length(vec2f(dot(pixel_x, mirrored_y), dot(pixel_y, mirrored_y))),
    );

    t.projection = abs(dot(e, normal)) * distance_to_centre / abs(facing);
    // The areas of a texel across its ray and of a pixel across its own.
    let area = abs(factor.x * factor.y) * (w * maps[k].texel.z / distance_to_centre);
    let pixels = abs(scale.x * scale.y) * sqrt(per_right * per_up) * ray_length;
    t.perspective = area * pixels;
    return t;
}

// What a pixel has that no map serves.
fn write_none(i: u32, why: u32) {
    let n = view.width * view.rows;
    for (var k = 0u; k < PLANES; k++) {
        result[k * n + i] = NAN_BITS;
    }
    result[PLANES * n + i] = why;
}

@compute @workgroup_size(8, 8)
fn footprint(@builtin(global_invocation_id) invocation: vec3u) {
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
        write_none(i, NOTHING);
        return;
    }
    let s = surface(pixel.xy, id);
    let p = vec3f(s.p_eye);
    if !faces_light(p, vec3f(s.normal)) {
        write_none(i, AVERTED);
        return;
    }
    let map = choose(p, f32(s.depth));
    if map == NO_MAP {
        write_none(i, NO_MAP);
        return;
    }
    let t = texel(map, s, vec2f(ndc_of(pixel.xy)));
    // Written so that a NaN is none.
    if !(t.major > 0.0 && t.major < LARGEST) {
        write_none(i, NO_MAP);
        return;
    }
    let n = view.width * view.rows;
    let numbers = array<f32, PLANES>(
        t.on_surface[0].x,
        t.on_surface[1].x,
        t.on_surface[0].y,
        t.on_surface[1].y,
        t.major,
        t.perspective,
        t.perspective_ts.x,
        t.perspective_ts.y,
        t.projection,
        view.unit * f32(s.depth) + view.depth_at_origin,
    );
    for (var k = 0u; k < PLANES; k++) {
        result[k * n + i] = bitcast<u32>(numbers[k]);
    }
    result[PLANES * n + i] = map;
}
