//! The adapters of this machine, and the choice of one.

use super::GpuError;

/// What an adapter is and can do.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct AdapterReport {
    /// The name that the driver gives.
    pub name: String,
    /// The interface it is reached through, for example `vulkan`.
    pub backend: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub device_type: &'static str,
    /// The driver and its version.
    pub driver: String,
    /// Whether it runs on the CPU.
    pub software: bool,
    /// Whether shaders may use f64.
    pub has_f64: bool,
    /// Whether shaders may use subgroup operations.
    pub has_subgroups: bool,
    /// Whether passes can be timed on the device.
    pub has_timestamps: bool,
    /// Largest buffer, bytes.
    pub max_buffer_bytes: u64,
    /// Largest part of a buffer that a shader sees at once, bytes.
    pub max_binding_bytes: u64,
    /// Most invocations in a workgroup.
    pub max_workgroup_invocations: u32,
    /// Most memory that a workgroup shares, bytes.
    pub max_workgroup_memory_bytes: u32,
    /// Most storage buffers that a shader sees.
    pub max_storage_buffers: u32,
}

/// An adapter that can be opened.
#[derive(Clone, Debug)]
pub struct Adapter {
    pub(super) inner: wgpu::Adapter,
    report: AdapterReport,
}

impl Adapter {
    /// What it is and can do.
    pub fn report(&self) -> &AdapterReport {
        &self.report
    }
}

/// The adapters of this machine, best first.
pub fn adapters() -> Vec<AdapterReport> {
    ranked().into_iter().map(|a| a.report).collect()
}

/// Picks an adapter.
///
/// With a `name`, the best whose name contains it, whatever the case, software or not; no such
/// adapter is an error that lists those there are. Without, the best: a discrete one before an
/// integrated one, then a virtual one, and one that runs on the CPU last. A software adapter is
/// only taken where `allow_software`: where it is not and there is no other, the answer is `None`.
pub fn choose(name: Option<&str>, allow_software: bool) -> Result<Option<Adapter>, GpuError> {
    let all = ranked();
    let available: Vec<String> = all.iter().map(|a| a.report.name.clone()).collect();
    let chosen = match name {
        Some(part) => {
            let part = part.to_lowercase();
            all.into_iter().find(|a| a.report.name.to_lowercase().contains(&part))
        }
        None => all.into_iter().find(|a| allow_software || !a.report.software),
    };
    if chosen.is_none() && (name.is_some() || allow_software) {
        return Err(GpuError::NoAdapter { wanted: name.map(str::to_owned), available });
    }
    Ok(chosen)
}

/// Every adapter, best first, in an order that does not depend on that of enumeration.
fn ranked() -> Vec<Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    if cfg!(target_os = "linux") {
        // Whether the workgroups that a device has counted are too many: they never are, and looking takes a dispatch more
        // for each pass. Elsewhere more hangs on it: Direct3D tells passes how many workgroups there are by it, and of Metal
        // wgpu keeps buffers below 4 GiB by it.
        descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    }
    let instance = wgpu::Instance::new(descriptor.with_env());
    let found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let mut all: Vec<Adapter> = found.into_iter().map(describe).collect();
    all.sort_by_key(|a| {
        let rank = ["discrete", "integrated", "virtual", "other", "software"]
            .iter()
            .position(|&kind| kind == a.report.device_type);
        // The same device may be listed once an interface.
        let interface =
            ["vulkan", "metal", "dx12"].iter().position(|&name| name == a.report.backend);
        (rank, interface.unwrap_or(usize::MAX), a.report.name.clone())
    });
    all
}

fn describe(inner: wgpu::Adapter) -> Adapter {
    let (info, features, limits) = (inner.get_info(), inner.features(), inner.limits());
    let device_type = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => "discrete",
        wgpu::DeviceType::IntegratedGpu => "integrated",
        wgpu::DeviceType::VirtualGpu => "virtual",
        wgpu::DeviceType::Cpu => "software",
        wgpu::DeviceType::Other => "other",
    };
    let report = AdapterReport {
        name: info.name,
        backend: info.backend.to_string(),
        device_type,
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        software: info.device_type == wgpu::DeviceType::Cpu,
        has_f64: features.contains(wgpu::Features::SHADER_F64),
        has_subgroups: features.contains(wgpu::Features::SUBGROUP),
        has_timestamps: features.contains(wgpu::Features::TIMESTAMP_QUERY),
        max_buffer_bytes: limits.max_buffer_size,
        max_binding_bytes: limits.max_storage_buffer_binding_size,
        max_workgroup_invocations: limits.max_compute_invocations_per_workgroup,
        max_workgroup_memory_bytes: limits.max_compute_workgroup_storage_size,
        max_storage_buffers: limits.max_storage_buffers_per_shader_stage,
    };
    Adapter { inner, report }
}
