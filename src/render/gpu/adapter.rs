//! Which graphics adapters there are, and which one a name means.

use wgpu::{Backends, DeviceType, DownlevelFlags, Instance, InstanceDescriptor, InstanceFlags};

use super::failure::guarded;
use crate::error::{Error, Result};

/// What is known of an adapter before it is opened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AdapterInfo {
    /// The device as its driver names it.
    pub name: String,
    /// "vulkan", "metal", "dx12" or "gl".
    pub backend: String,
    /// "discrete", "integrated", "virtual", "cpu" or "other".
    pub device_type: String,
    /// The driver and its version, as far as it tells.
    pub driver: String,
}

impl AdapterInfo {
    fn of(info: &wgpu::AdapterInfo) -> Self {
        let device_type = match info.device_type {
            DeviceType::DiscreteGpu => "discrete",
            DeviceType::IntegratedGpu => "integrated",
            DeviceType::VirtualGpu => "virtual",
            DeviceType::Cpu => "cpu",
            DeviceType::Other => "other",
        };
        let driver = [info.driver.as_str(), info.driver_info.as_str()];
        Self {
            name: info.name.clone(),
            backend: info.backend.to_str().to_string(),
            device_type: device_type.to_string(),
            driver: driver.iter().filter(|s| !s.is_empty()).copied().collect::<Vec<_>>().join(" "),
        }
    }

    /// Whether a user who typed `wanted` means this adapter: part of its name or of its backend, in any case.
    fn matches(&self, wanted: &str) -> bool {
        let wanted = wanted.to_lowercase();
        self.name.to_lowercase().contains(&wanted) || self.backend.to_lowercase().contains(&wanted)
    }
}

impl std::fmt::Display for AdapterInfo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({}, {}", self.name, self.backend, self.device_type)?;
        if !self.driver.is_empty() {
            write!(f, ", {}", self.driver)?;
        }
        f.write_str(")")
    }
}

/// Every graphics adapter of this machine, the one that [`super::GpuRenderer::new`] takes unasked first.
pub fn adapters() -> Vec<AdapterInfo> {
    // A driver that brings the loader down offers no adapter.
    let found = guarded(|| Ok(usable())).unwrap_or_default();
    found.iter().map(|(_, info)| info.clone()).collect()
}

/// The adapter that `wanted` names, or the best one.
pub(super) fn choose(wanted: Option<&str>) -> Result<(wgpu::Adapter, AdapterInfo)> {
    let all = usable();
    let found: Vec<String> = all.iter().map(|(_, info)| info.to_string()).collect();
    let wanted = wanted.map(str::trim).filter(|name| !name.is_empty());
    let chosen = all.into_iter().find(|(_, info)| wanted.is_none_or(|name| info.matches(name)));
    chosen.ok_or_else(|| Error::NoAdapter {
        wanted: wanted.map(str::to_string),
        fix: if found.is_empty() { NO_ADAPTER_FIX } else { "name one of these or none, or use backend \"cpu\"" }.into(),
        found,
    })
}

const NO_ADAPTER_FIX: &str = if cfg!(target_os = "linux") {
    "install a graphics driver (a software one on Debian: apt-get install mesa-vulkan-drivers libvulkan1), or use backend \"cpu\""
} else {
    "install a graphics driver, or use backend \"cpu\""
};

/// The adapters that can draw and give back a depth map, best first.
///
/// OpenGL is asked only where nothing else is found: it offers the same devices once more, with less.
fn usable() -> Vec<(wgpu::Adapter, AdapterInfo)> {
    let modern = of_backends(Backends::VULKAN | Backends::METAL | Backends::DX12);
    if modern.is_empty() { of_backends(Backends::GL) } else { modern }
}

fn of_backends(backends: Backends) -> Vec<(wgpu::Adapter, AdapterInfo)> {
    // No debug layers in any profile: they cost time, and error reports do not depend on them.
    let flags = InstanceFlags::empty();
    let descriptor = InstanceDescriptor { backends, flags, ..InstanceDescriptor::new_without_display_handle() };
    let mut all = pollster::block_on(Instance::new(descriptor).enumerate_adapters(backends));
    all.retain(|adapter| {
        let flags = adapter.get_downlevel_capabilities().flags;
        flags.contains(DownlevelFlags::DEPTH_TEXTURE_AND_BUFFER_COPIES | DownlevelFlags::BASE_VERTEX)
    });
    // The sort is stable: adapters of one kind stay in the order their drivers give.
    all.sort_by_key(|adapter| match adapter.get_info().device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    });
    let with_info = |adapter: wgpu::Adapter| {
        let info = AdapterInfo::of(&adapter.get_info());
        (adapter, info)
    };
    all.into_iter().map(with_info).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_matches_in_any_case_by_part_or_by_backend() {
        let info = AdapterInfo {
            name: "llvmpipe (LLVM 15.0.6, 256 bits)".into(),
            backend: "vulkan".into(),
            device_type: "cpu".into(),
            driver: "llvmpipe Mesa 22.3.6".into(),
        };
        assert!(info.matches("LLVMpipe") && info.matches("Vulkan") && !info.matches("nvidia"));
        assert_eq!(info.to_string(), "llvmpipe (LLVM 15.0.6, 256 bits) (vulkan, cpu, llvmpipe Mesa 22.3.6)");
    }
}
