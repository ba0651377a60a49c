// The light that a filter makes of comparisons; twin of render/filter/kernel.rs and kernels.rs; lookup.wgsl comes before this text.
//
// Space: "eye" of surface.wgsl. Space "texel": the map in texels, x to the right, y down.
// The filter is a part of lookup.wgsl's group 1.

struct Kernel {
    // Of a disc.
    points: u32,
    // TEXELS or PIXELS.
    unit: u32,
    // Width, or radius of a disc, in its unit.
    length: f32,
    unused: u32,
    // Points of the unit disc, two each.
    disc: array<vec4f, 128>,
}

const NEAREST = 0u;
const BILINEAR = 1u;
const BOX = 2u;
const TENT = 3u;
const DISC = 4u;
const TEXELS = 0u;

// Widest kernel, texels along each axis.
const WIDEST = 64.0;

// A kernel at one receiver, texels.
struct Shape {
    // Also a box of one texel.
    is_bilinear: bool,
    // Of box and tent.
    widths: vec2f,
    // The unit disc becomes the kernel's: rows x and y.
    axes_x: vec2f,
    axes_y: vec2f,
    // How far from the place the centre of a texel that is compared can lie along each axis.
    reach: vec2f,
}

// A width within limits; the largest for a NaN, of a plane seen edge on.
fn held_width(width: f32, least: f32, most: f32) -> f32 {
    return select(most, max(width, least), width <= most);
}

// Half the extent of a disc along an axis, with a length within limits; along the axis where it has no direction.
fn held_row(row: vec2f, axis: vec2f) -> vec2f {
    let size = length(row);
    let held = held_width(size, 0.5, 0.5 * WIDEST);
    if size > 0.0 && size < BOUNDLESS {
        return row * (held / size);
    }
    return axis * held;
}

// The kernel at a receiver in a map whose texel coordinates have these gradients there.
fn shape_at(p: real3, normal: real3, grad_x: real3, grad_y: real3) -> Shape {
    var shape: Shape;
    shape.is_bilinear = filter_kind == BILINEAR;
    if filter_kind == NEAREST || filter_kind == BILINEAR {
        shape.reach = vec2f(select(0.5, 1.0, filter_kind == BILINEAR));
        return shape;
    }
    // Steps of the kernel's unit to the right and down, in texels.
    var x = vec2f(1.0, 0.0);
    var y = vec2f(0.0, 1.0);
    if lookup.kernel.unit != TEXELS {
        // How far the point moves on its plane as its pixel moves by one.
        let ray = select(p, view_forward(), view.rays == PARALLEL);
        let w = w_at(dot(p, view_forward()));
        let facing = dot(normal, ray);
        let across = view_right() * (2.0 * w / real(view.width));
        let down = view_up() * (-2.0 * w / real(view.height));
        let step_across = across - ray * (dot(normal, across) / facing);
        let step_down = down - ray * (dot(normal, down) / facing);
        x = vec2f(real2(dot(grad_x, step_across), dot(grad_x, step_down)));
        y = vec2f(real2(dot(grad_y, step_across), dot(grad_y, step_down)));
    }
    if filter_kind == DISC {
        shape.axes_x = lookup.kernel.length * x;
        shape.axes_y = lookup.kernel.length * y;
        if lookup.kernel.unit != TEXELS {
            shape.axes_x = held_row(shape.axes_x, vec2f(1.0, 0.0));
            shape.axes_y = held_row(shape.axes_y, vec2f(0.0, 1.0));
        }
        shape.reach = vec2f(length(shape.axes_x), length(shape.axes_y)) + 0.5;
        return shape;
    }
    shape.widths = lookup.kernel.length * vec2f(length(x), length(y));
    if lookup.kernel.unit != TEXELS {
        shape.widths = vec2f(held_width(shape.widths.x, 1.0, WIDEST), held_width(shape.widths.y, 1.0, WIDEST));
    }
    shape.is_bilinear = filter_kind == BOX && shape.widths.x == 1.0 && shape.widths.y == 1.0;
    shape.reach = 0.5 * shape.widths + 0.5;
    return shape;
}

// Of a tent from -1/2 to 1/2, from its middle.
fn tent_integral(t: f32) -> f32 {
    let u = clamp(2.0 * t, -1.0, 1.0);
    return u - 0.5 * u * abs(u);
}

// The weight of a texel that begins at `from`, relative to the place, along one axis.
fn weight_of(first: f32, width: f32) -> f32 {
    if filter_kind == BOX {
        return max(min(first + 1.0, 0.5 * width) - max(first, -0.5 * width), 0.0) / width;
    }
    return tent_integral((first + 1.0) / width) - tent_integral(first / width);
}

fn separable(layer: u32, at: Comparison) -> f32 {
    // Relative to the texel that the place is in: nothing of the place's own digits is lost.
    let f = at.within;
    let begin = floor(f - 0.5 * at.shape.widths);
    let count = vec2i(ceil(at.shape.widths)) + 1;
    let first = at.texel + vec2i(begin);
    var sum = 0.0;
    var total = 0.0;
    for (var j = 0; j < count.y; j++) {
        let down = weight_of(begin.y + f32(j) - f.y, at.shape.widths.y);
        var row = 0.0;
        var whole = 0.0;
        for (var i = 0; i < count.x; i++) {
            let across = weight_of(begin.x + f32(i) - f.x, at.shape.widths.x);
            row += across * lit(layer, first + vec2i(i, j), at);
            whole += across;
        }
        sum += down * row;
        total += down * whole;
    }
    // Of all weights, which sum to 1 but for roundings: what is lit throughout is 1.
    return sum / total;
}

fn light(map: u32, p: real3, normal: real3) -> f32 {
    let at = compare_at(maps[map], p, normal);
    let layer = map - lookup.first_map;
    if at.is_lit {
        return 1.0;
    }
    if filter_kind == NEAREST {
        return lit(layer, at.texel, at);
    }
    if filter_kind == DISC {
        var sum = 0.0;
        for (var i = 0u; i < lookup.kernel.points; i++) {
            let two = lookup.kernel.disc[i / 2u];
            let q = select(two.xy, two.zw, i % 2u == 1u);
            let place = at.within + vec2f(dot(at.shape.axes_x, q), dot(at.shape.axes_y, q));
            sum += lit(layer, at.texel + vec2i(floor(place)), at);
        }
        return sum / f32(lookup.kernel.points);
    }
    if at.shape.is_bilinear {
        let corner = floor(at.within - 0.5);
        let f = at.within - 0.5 - corner;
        let texel = at.texel + vec2i(corner);
        let top = (1.0 - f.x) * lit(layer, texel, at) + f.x * lit(layer, texel + vec2i(1, 0), at);
        let bottom = (1.0 - f.x) * lit(layer, texel + vec2i(0, 1), at) + f.x * lit(layer, texel + vec2i(1, 1), at);
        return (1.0 - f.y) * top + f.y * bottom;
    }
    return separable(layer, at);
}
