// Which fragments of a map are drawn: those of averted faces, or those behind the first depth. Before layers_plain.wgsl or
// layers_tested.wgsl; twin of cpu/faces.rs.
//
// Clip space: of a map, 0 <= z <= w, y up; z / w is 1 at the near and 0 at the far plane where depth is reversed.

// The sign of the turn, counter-clockwise with y up, of triangles that show their outer side: a map keeps the winding that the
// light sees where its determinant is negative, and a mirrored instance turns the sign once more. Of a matrix with reversed
// depth it is the other sign.
fn outer_turn(x: vec4f, y: vec4f, z: vec4f, w: vec4f) -> f32 {
    // A positive factor of a column changes no sign and keeps the product in range.
    return select(1.0, -1.0, determinant(mat4x4f(normalize(x), normalize(y), normalize(z), normalize(w))) > 0.0);
}

fn is_averted(turns_left: bool, outer: f32) -> bool {
    return select(-1.0, 1.0, turns_left) * outer < 0.0;
}
