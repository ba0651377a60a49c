// The numbers of surface.wgsl and lookup.wgsl on devices without double precision.

alias real = f32;
alias real2 = vec2<f32>;
alias real3 = vec3<f32>;
alias real4 = vec4<f32>;

const IS_DOUBLE = false;
// Relative distance of neighbouring numbers.
const EPSILON = 1.0 / 8388608.0;
