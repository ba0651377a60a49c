//! An open device, and the failures it reports.
//!
//! wgpu reports errors in four ways: as results, to a handler for those that no scope caught, to a callback when the device
//! is lost, and, where it knows no other way out, by a panic. All four end as an [`Error::Device`].

use std::sync::{Arc, Mutex};
use std::time::Duration;

use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, CommandBuffer, CommandEncoder, Device, DeviceDescriptor, DownlevelFlags,
    Features, Limits, PollError, PollType, Queue,
};

use super::adapter::{self, AdapterInfo};
use super::failure::{from_wgpu, lock};
use crate::error::{Error, Result};
use crate::progress::Progress;

/// How long one wait lasts before progress is asked again: short to a user who pressed Ctrl-C, long to a device.
const WAIT: Duration = Duration::from_millis(50);

/// A device, its queue, and what it told of its failures.
pub(super) struct Gpu {
    pub device: Device,
    pub queue: Queue,
    pub info: AdapterInfo,
    pub limits: Limits,
    /// Whether compute shaders, and with them G-buffers and masks, are there.
    pub has_compute: bool,
    failures: Arc<Mutex<Failures>>,
}

#[derive(Default)]
struct Failures {
    /// The first error since it was last asked for.
    error: Option<Error>,
    /// Why the device is gone for good.
    lost: Option<String>,
}

impl Gpu {
    /// The device of the adapter that `wanted` names, or of the best one.
    pub fn open(wanted: Option<&str>, allowed: Features) -> Result<Self> {
        let (adapter, info) = adapter::choose(wanted)?;
        let limits = adapter.limits();
        let flags = adapter.get_downlevel_capabilities().flags;
        let descriptor = DeviceDescriptor {
            label: Some("shadowlab"),
            required_features: adapter.features() & allowed,
            // Everything the adapter has: sizes are checked against it before anything is created.
            required_limits: limits.clone(),
            ..DeviceDescriptor::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| Error::Device {
                what: format!("{info} could not be opened: {error}"),
                fix: "name another adapter, or use backend \"cpu\"".into(),
            })?;
        let failures = Arc::new(Mutex::new(Failures::default()));
        let seen = failures.clone();
        device.on_uncaptured_error(Arc::new(move |error| {
            lock(&seen).error.get_or_insert_with(|| from_wgpu(&error));
        }));
        let seen = failures.clone();
        device.set_device_lost_callback(move |reason, message| {
            lock(&seen).lost.get_or_insert_with(|| format!("{reason:?} {message}").trim_end().to_string());
        });
        // Of a mask: view, placements, vertices, indices, light, maps and lookup to read from, one to write to. WebGPU has as many.
        let has_compute = flags.contains(DownlevelFlags::COMPUTE_SHADERS)
            && limits.max_storage_buffers_per_shader_stage >= 8
            && limits.max_compute_workgroups_per_dimension > 0;
        Ok(Self { device, queue, info, limits, has_compute, failures })
    }

    /// The first failure since the last call, if any.
    pub fn check(&self) -> Result<()> {
        let mut failures = lock(&self.failures);
        let error = failures.error.take();
        if let Some(reason) = &failures.lost {
            return Err(Error::Device {
                what: format!("the device of {} was lost: {reason}", self.info.name),
                fix: "make a new renderer, or use backend \"cpu\"".into(),
            });
        }
        error.map_or(Ok(()), Err)
    }

    /// A buffer with parts one after the other.
    pub fn filled(&self, label: &str, usage: BufferUsages, parts: &[&[u8]]) -> Result<Buffer> {
        let buffer = self.device.create_buffer(&BufferDescriptor {
            label: Some(label),
            size: parts.iter().map(|p| p.len() as u64).sum(),
            usage,
            mapped_at_creation: true,
        });
        self.check()?;
        let mut view = buffer.get_mapped_range_mut(..).map_err(|error| Error::Device {
            what: format!("{label} could not be written: {error}"),
            fix: "try again, or use backend \"cpu\"".into(),
        })?;
        let mut at = 0;
        for part in parts {
            view.slice(at..at + part.len()).copy_from_slice(part);
            at += part.len();
        }
        drop(view);
        buffer.unmap();
        self.check()?;
        Ok(buffer)
    }

    /// A fresh list of commands.
    pub fn encoder(&self, label: &str) -> CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(label) })
    }

    /// Sends commands and waits for them, and for the mappings asked for before, stopping when the caller asks to.
    pub fn finish(&self, commands: CommandBuffer, progress: &Progress) -> Result<()> {
        let submission = self.queue.submit([commands]);
        self.check()?;
        loop {
            let wait = PollType::Wait { submission_index: Some(submission.clone()), timeout: Some(WAIT) };
            match self.device.poll(wait) {
                Ok(_) => return self.check(),
                Err(PollError::Timeout) => {
                    self.check()?;
                    progress.check()?;
                }
                Err(error) => {
                    let fix = "try again, or use backend \"cpu\"".into();
                    return Err(Error::Device { what: error.to_string(), fix });
                }
            }
        }
    }

    /// Waits until the device has nothing to do, so that what nobody holds is gone.
    pub fn settle(&self) -> Result<()> {
        self.device.poll(PollType::wait_indefinitely()).map_err(|error| {
            let fix = "make a new renderer, or use backend \"cpu\"".into();
            Error::Device { what: error.to_string(), fix }
        })?;
        self.check()
    }

    /// The error of a size that is over one of the device's limits.
    pub fn over_limit(&self, what: &str, wanted: u64, limit: &str, most: u64) -> Error {
        Error::Device {
            what: format!("{what} needs {wanted}, but {limit} of {} is {most}", self.info.name),
            fix: "choose a smaller size, or use backend \"cpu\"".into(),
        }
    }

    /// Checks the sides and the number of layers of a texture.
    pub fn check_texture(&self, what: &str, size: [u32; 2], layers: u32) -> Result<()> {
        let most = self.limits.max_texture_dimension_2d;
        if let Some(&side) = size.iter().find(|&&side| side > most) {
            return Err(self.over_limit(
                &format!("{what} of {} x {} texels", size[0], size[1]),
                side.into(),
                "max_texture_dimension_2d",
                most.into(),
            ));
        }
        let most = self.limits.max_texture_array_layers;
        if layers > most {
            return Err(self.over_limit(
                &format!("{what} of {layers} layers"),
                layers.into(),
                "max_texture_array_layers",
                most.into(),
            ));
        }
        Ok(())
    }

    /// Checks the bytes of a buffer that no shader reads.
    pub fn check_buffer(&self, what: &str, bytes: u64) -> Result<()> {
        let most = self.limits.max_buffer_size;
        if bytes > most { Err(self.over_limit(what, bytes, "max_buffer_size (bytes)", most)) } else { Ok(()) }
    }

    /// Checks the bytes of a buffer that shaders bind as storage.
    pub fn check_binding(&self, what: &str, bytes: u64) -> Result<()> {
        self.check_buffer(what, bytes)?;
        let most = self.limits.max_storage_buffer_binding_size;
        if bytes > most {
            return Err(self.over_limit(what, bytes, "max_storage_buffer_binding_size (bytes)", most));
        }
        Ok(())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::Write;

    use super::*;

    /// A device with at most the given features; none, which is told, on a machine without adapters.
    pub fn opened(allowed: Features) -> Option<Gpu> {
        match Gpu::open(None, allowed) {
            Ok(gpu) => Some(gpu),
            Err(Error::NoAdapter { .. })
                if !std::env::var("SHADOWLAB_REQUIRE_ALL").is_ok_and(|v| v != "0" && !v.is_empty()) =>
            {
                // Not eprintln: the test harness swallows what it prints in tests that pass, and skips are counted.
                writeln!(
                    std::io::stderr(),
                    "\nskipped: no graphics adapter (SHADOWLAB_REQUIRE_ALL=1 makes this a failure)"
                )
                .expect("standard error");
                None
            }
            Err(error) => panic!("{error}"),
        }
    }
}
