//! The Python extension module: thin wrappers with the same stems as the core.

mod aliasing;
mod alpha_states;
mod alpha_test;
mod arguments;
mod arrays;
mod bias;
mod bias_distance;
mod blur;
mod camera;
mod camera_changes;
mod camera_matrices;
mod causes;
mod compared;
mod convert;
mod culled;
mod drivers;
mod exceptions;
mod filter;
mod footprint;
mod gbuffer;
mod library;
mod light;
mod map_fields;
mod map_states;
mod mask_settings;
mod mesh;
mod note;
mod parameterization;
mod picture;
mod png;
mod render;
mod renderer_run;
mod sample_states;
mod samples;
mod scene;
mod scene_states;
mod settings;
mod state;
mod stored;
mod summary;
mod surfaces;
mod survey;
mod technique;
mod threads;
mod trace;
mod travel;
mod usage;

/// The private extension module behind the package.
#[pyo3::pymodule]
mod _core {
    #[pymodule_export]
    use super::aliasing::{PyMisclassified, misclassified};
    #[pymodule_export]
    use super::bias::PyBias;
    #[pymodule_export]
    use super::bias_distance::bias_distance;
    #[pymodule_export]
    use super::blur::blur;
    #[pymodule_export]
    use super::camera::PyCamera;
    #[pymodule_export]
    use super::causes::{causes, look_up};
    #[pymodule_export]
    use super::compared::{blended, compared};
    #[pymodule_export]
    use super::culled::looking_pays;
    #[pymodule_export]
    use super::drivers::adapters;
    #[pymodule_export]
    use super::filter::{filter_kinds, filter_text};
    #[pymodule_export]
    use super::footprint::{footprint, footprint_at};
    #[pymodule_export]
    use super::gbuffer::PyGBuffer;
    #[pymodule_export]
    use super::library::{library_build, library_specs};
    #[pymodule_export]
    use super::light::{PyDirectionalLight, PyPointLight, PySpotLight};
    #[pymodule_export]
    use super::mesh::PyMesh;
    #[pymodule_export]
    use super::note::PyNote;
    #[pymodule_export]
    use super::parameterization::{PyParameterization, PyPartition};
    #[pymodule_export]
    use super::picture::shade;
    #[pymodule_export]
    use super::png::png;
    #[pymodule_export]
    use super::render::PyRenderer;
    #[pymodule_export]
    use super::samples::{PySamples, samples_under};
    #[pymodule_export]
    use super::scene::PyScene;
    #[pymodule_export]
    use super::stored::{PyStored, depth_rows, depth_steps};
    #[pymodule_export]
    use super::summary::{cause_counts, causes_by_depth, compared_depths, summarize, summarize_bands};
    #[pymodule_export]
    use super::surfaces::{moved_gbuffer, same_instances, shadows_at};
    #[pymodule_export]
    use super::survey::{drawn_samples, mapped_gaps, mapped_states, predict_wrong};
    #[pymodule_export]
    use super::technique::{PyTechnique, renamed_words, technique_specs};
    #[pymodule_export]
    use super::threads::{set_threads, thread_count};
    #[pymodule_export]
    use super::trace::{face_corners, first_hit, occluded, trace_memory, trace_shadow_mask, trace_shadow_masks};
    #[pymodule_export]
    use super::travel::restore;
    #[pymodule_export]
    use super::usage::{filter_reach, reads, texel_coordinates};

    /// The package's version.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
