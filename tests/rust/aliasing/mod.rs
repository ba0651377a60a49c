//! What texels look like in the image.

mod footprint;
