// The numbers of surface.wgsl and lookup.wgsl on devices that have double precision.

alias real = f64;
alias real2 = vec2<f64>;
alias real3 = vec3<f64>;
alias real4 = vec4<f64>;

const IS_DOUBLE = true;
// Relative distance of numbers that pairs of single precision tell apart: 2^-46.
const EPSILON = 1.0 / 70368744177664.0;
