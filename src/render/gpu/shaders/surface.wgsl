// The surface that a pixel shows: the ray through its centre meets the plane of its triangle.
//
// Numbers: `real` of single.wgsl or double.wgsl, one of which comes before this text.
// Space "eye": world axes, origin at a perspective eye, or of parallel rays on the view axis, in units of a power of two near the size of scene and view, so that single
// precision is relative to the eye and its range is never left.
// Group 0: 0 view (storage: see pipelines.rs), 1 ids (see ids.wgsl), 2 placements of the visible instances, 3 p_local of the meshes of a group, 4 their
// vertex indices.
// Part of gbuffer.wgsl, lookup.wgsl and footprint.wgsl, which see to one pixel an invocation.

struct View {
    // NDC (x, y) is center + x * right + y * up: where rays from the eye meet camera depth 1, or where parallel ones meet the
    // origin's depth.
    right: vec3f,
    width: u32,
    up: vec3f,
    height: u32,
    forward: vec3f,
    // The rows this dispatch sees to.
    first_row: u32,
    eye_minus_origin: vec3f,
    rows: u32,
    // World units in a unit of this space.
    unit: f32,
    // The slots whose geometry is bound.
    first_slot: u32,
    end_slot: u32,
    // FROM_EYE or PARALLEL.
    rays: u32,
    center: vec3f,
    // No surface is nearer. Depths are those along the view from the origin of this space.
    nearest: f32,
    // The picture's middle from the view axis, in half widths and half heights.
    shift: vec2f,
    // World units.
    depth_at_origin: f32,
    unused: u32,
    // What single precision leaves of the vectors above.
    right_low: vec3f,
    unused_right: u32,
    up_low: vec3f,
    unused_up: u32,
    forward_low: vec3f,
    unused_forward: u32,
    eye_minus_origin_low: vec3f,
    unused_eye: u32,
    center_low: vec3f,
    unused_center: u32,
}

const FROM_EYE = 0u;
const PARALLEL = 1u;

struct Placement {
    // Rows, each with what single precision leaves of it.
    eye_from_local_x: array<vec4f, 2>,
    eye_from_local_y: array<vec4f, 2>,
    eye_from_local_z: array<vec4f, 2>,
    first_vertex: u32,
    first_index: u32,
    instance: u32,
    unused: u32,
}

@group(0) @binding(0) var<storage, read> view: View;
@group(0) @binding(1) var ids: texture_2d<u32>;
@group(0) @binding(2) var<storage, read> placements: array<Placement>;
@group(0) @binding(3) var<storage, read> vertices: array<f32>;
@group(0) @binding(4) var<storage, read> indices: array<u32>;

struct Surface {
    p_eye: real3,
    // Along the view, from the origin.
    depth: real,
    // Unit, on the side that the eye sees.
    normal: real3,
    triangle: u32,
    instance: u32,
}

// What a number and its rest sum to, as far as there are digits.
fn whole3(high: vec3f, low: vec3f) -> real3 {
    return real3(high) + real3(low);
}

fn whole4(pair: array<vec4f, 2>) -> real4 {
    return real4(pair[0]) + real4(pair[1]);
}

fn view_right() -> real3 {
    return whole3(view.right, view.right_low);
}

fn view_up() -> real3 {
    return whole3(view.up, view.up_low);
}

fn view_forward() -> real3 {
    return whole3(view.forward, view.forward_low);
}

fn eye_minus_origin() -> real3 {
    return whole3(view.eye_minus_origin, view.eye_minus_origin_low);
}

fn vertex(placement: Placement, corner: u32) -> real3 {
    let at = 3 * (placement.first_vertex + indices[corner]);
    return real3(vec3f(vertices[at], vertices[at + 1], vertices[at + 2]));
}

fn linear(row_x: real4, row_y: real4, row_z: real4, v: real3) -> real3 {
    return real3(dot(row_x.xyz, v), dot(row_y.xyz, v), dot(row_z.xyz, v));
}

fn largest(v: real3) -> real {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// NDC of a pixel's centre.
fn ndc_of(pixel: vec2u) -> real2 {
    let size = vec2f(f32(view.width), f32(view.height));
    return real2(vec2f(2.0 * f32(pixel.x) + 1.0 - size.x, size.y - 2.0 * f32(pixel.y) - 1.0)) / real2(size);
}

struct Ray {
    // At depth 0.
    origin: real3,
    // Of depth 1.
    direction: real3,
}

// The ray through a place of the image.
fn ray_through(ndc: real2) -> Ray {
    let place = whole3(view.center, view.center_low) + ndc.x * view_right() + ndc.y * view_up();
    if view.rays == PARALLEL {
        return Ray(place, view_forward());
    }
    return Ray(real3(), place);
}

// What places across the view are divided by at a depth.
fn w_at(depth: real) -> real {
    return select(depth, real(1.0), view.rays == PARALLEL);
}

// How far beside a triangle its plane may be met, in parts of the triangle: see render::cpu::gbuffer.
const BESIDE = 1.0 / 64.0;

// An interval of depths, empty where it ends before it begins.
struct Passage {
    begin: real,
    end: real,
}

// What is left of a passage on the inner side of a line: 0 on it, and 1 at the corner before it.
fn cut_passage(passage: Passage, at_origin: real, per_depth: real) -> Passage {
    if per_depth == 0.0 {
        return Passage(passage.begin, select(passage.begin - 1.0, passage.end, at_origin >= 0.0));
    }
    let crossed = -at_origin / per_depth;
    if per_depth > 0.0 {
        return Passage(max(passage.begin, crossed), passage.end);
    }
    return Passage(passage.begin, min(passage.end, crossed));
}

// Where the plane of a triangle (a corner, two edges from it over their length, their cross product) is met between two depths:
// held where the ray passes by the triangle.
fn depth_on(a: real3, edges: array<real3, 2>, across: real3, scale: real, ray: Ray, nearest: real, farthest: real) -> real {
    let facing = dot(across, ray.direction);
    let met = clamp(select(nearest, dot(across, a - ray.origin) / facing, facing != 0.0), nearest, farthest);
    // Parts of the triangle along both edges from the corner, of a point of the plane: at the ray's origin, and for each depth.
    let along_ab = cross(edges[1], across) * (1.0 / (dot(across, across) * scale));
    let along_ac = cross(across, edges[0]) * (1.0 / (dot(across, across) * scale));
    let from_a = ray.origin - a;
    let here = real2(dot(along_ab, from_a), dot(along_ac, from_a));
    let per_depth = real2(dot(along_ab, ray.direction), dot(along_ac, ray.direction));
    // Of differences of places that nearly cancel.
    let part = real2(dot(along_ab, from_a + met * ray.direction), dot(along_ac, from_a + met * ray.direction));
    let is_edge_on = abs(facing) <= 16.0 * EPSILON * length(across) * length(ray.direction);
    if !is_edge_on && part.x >= -BESIDE && part.y >= -BESIDE && part.x + part.y <= 1.0 + BESIDE {
        return met;
    }
    var passage = Passage(nearest, farthest);
    passage = cut_passage(passage, here.x + BESIDE, per_depth.x);
    passage = cut_passage(passage, here.y + BESIDE, per_depth.y);
    passage = cut_passage(passage, 1.0 + BESIDE - here.x - here.y, -per_depth.x - per_depth.y);
    if !(passage.begin <= passage.end) {
        return met;
    }
    return select(clamp(met, passage.begin, passage.end), passage.begin, is_edge_on);
}

// Of a pixel that shows the triangle `id.y` of slot `id.x - 1`.
fn surface(pixel: vec2u, id: vec2u) -> Surface {
    let placement = placements[id.x - 1];
    let corner = placement.first_index + 3 * id.y;
    let a_local = vertex(placement, corner);
    let b_local = vertex(placement, corner + 1);
    let c_local = vertex(placement, corner + 2);
    let row_x = whole4(placement.eye_from_local_x);
    let row_y = whole4(placement.eye_from_local_y);
    let row_z = whole4(placement.eye_from_local_z);
    let a = linear(row_x, row_y, row_z, a_local) + real3(row_x.w, row_y.w, row_z.w);
    // Edges from differences in the local frame: nearly exact there, while a difference of two places is not.
    let ab = linear(row_x, row_y, row_z, b_local - a_local);
    let ac = linear(row_x, row_y, row_z, c_local - a_local);
    // Transformed first, then crossed: right under mirrored and sheared transforms. Scaled: a product of two small edges
    // must not vanish.
    let scale = max(largest(ab), largest(ac));
    let inverse = select(real(0.0), 1.0 / scale, scale > 0.0);
    let across = cross(ab * inverse, ac * inverse);
    let area = length(across);

    let ray = ray_through(ndc_of(pixel));

    // Camera depths of the corners: a triangle seen edge on is met within them, whatever rounding makes of the quotient.
    let forward = view_forward();
    let depth_a = dot(a, forward);
    let depth_b = depth_a + dot(ab, forward);
    let depth_c = depth_a + dot(ac, forward);
    let nearest = max(min(depth_a, min(depth_b, depth_c)), real(view.nearest));
    let farthest = max(depth_a, max(depth_b, depth_c));

    var s: Surface;
    s.triangle = id.y;
    s.instance = placement.instance;
    if area > 0.0 {
        let facing = dot(across, ray.direction);
        s.normal = across / select(area, -area, facing > 0.0);
        let edges = array<real3, 2>(ab * inverse, ac * inverse);
        s.depth = depth_on(a, edges, across, scale, ray, nearest, farthest);
    } else {
        // No area, yet a pixel of it on the grid of sub-pixels: it faces whoever looks.
        s.normal = -normalize(ray.direction);
        s.depth = nearest;
    }
    s.p_eye = ray.origin + s.depth * ray.direction;
    return s;
}

// The pixel of an invocation, or none: 0 in z.
fn pixel_of(invocation: vec3u) -> vec3u {
    let inside = invocation.x < view.width && invocation.y < view.rows;
    return vec3u(invocation.x, invocation.y + view.first_row, select(0u, 1u, inside));
}

// Whether this dispatch sees to a pixel: its geometry is bound, or it shows nothing and this is the first dispatch.
fn is_mine(id: vec2u) -> bool {
    if id.x == 0 {
        return view.first_slot == 0;
    }
    return id.x - 1 >= view.first_slot && id.x - 1 < view.end_slot;
}
