//! The renderer on a graphics device: wgpu, headless, Vulkan, Metal or DirectX 12, OpenGL where it can.
//!
//! Nothing here touches a driver before [`GpuRenderer::new`] or [`adapters`] is called.

mod adapter;
mod alpha_tests;
mod device;
mod draw_list;
mod exact;
mod failure;
mod guard_band;
mod kernel;
mod layer_pipelines;
mod mask_pipelines;
#[cfg(test)]
mod native_formats;
mod pairs;
mod passes;
mod pipelines;
mod pool;
mod readback;
mod renderer;
mod scene_cache;
mod stored;
mod surface;
mod surface_passes;
mod uniforms;

pub use adapter::{AdapterInfo, adapters};
pub use renderer::GpuRenderer;
