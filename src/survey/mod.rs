//! Surveys of a view: samples of what is seen, drawn; and wrong pixels of maps foretold from them.

mod asked_maps;
mod draw;
mod edge_width;
mod predict;
mod reading;

pub use draw::{
    SURVEY_COUNT, SURVEY_MAP, SURVEY_SIDE, mapped_gaps, mapped_states, samples_of_surfaces, samples_of_view,
    survey_size,
};
pub use edge_width::{edge_width, missed};
pub use predict::{outside, predict};
