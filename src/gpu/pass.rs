//! A pass: a pipeline, its buffers, and how many invocations it runs.

use std::sync::Arc;

use super::link::{Binding, Holds, PassSource};
use super::{Buffer, Device, GpuError};

/// A compiled shader with the layout of its buffers.
#[derive(Debug)]
pub(super) struct Pipeline {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

/// A pass that is ready to run.
#[derive(Clone, Debug)]
pub struct Pass {
    pipeline: Arc<Pipeline>,
    buffers: wgpu::BindGroup,
    workgroups: Workgroups,
}

/// How many workgroups a pass has.
#[derive(Clone, Debug)]
enum Workgroups {
    /// So many along x and y.
    Known([u32; 2]),
    /// What the device has written here.
    OnDevice(wgpu::Buffer),
}

impl Pass {
    pub(super) fn record(&self, compute: &mut wgpu::ComputePass<'_>) {
        if matches!(self.workgroups, Workgroups::Known([0, _])) {
            return;
        }
        compute.set_pipeline(&self.pipeline.pipeline);
        compute.set_bind_group(0, &self.buffers, &[]);
        match &self.workgroups {
            Workgroups::Known([x, y]) => compute.dispatch_workgroups(*x, *y, 1),
            Workgroups::OnDevice(buffer) => compute.dispatch_workgroups_indirect(buffer, 0),
        }
    }

    /// The same with the workgroups that other passes have written to `buffer`, from
    /// [`Device::storage_with_workgroups`].
    #[must_use]
    pub fn with_workgroups(self, buffer: &Buffer) -> Self {
        Self { workgroups: Workgroups::OnDevice(buffer.inner.clone()), ..self }
    }
}

impl Device {
    /// The pass of `source` on `buffers` (in the order of its bindings), with at least `threads`
    /// invocations: shaders leave the rest of the last workgroups idle.
    pub fn pass(
        &self,
        source: &PassSource,
        buffers: &[&Buffer],
        threads: u64,
    ) -> Result<Pass, GpuError> {
        if buffers.len() != source.bindings.len() {
            return Err(GpuError::BufferCount {
                pass: source.pass.to_owned(),
                declared: source.bindings.len(),
                given: buffers.len(),
            });
        }
        let most = self.raw().limits().max_storage_buffers_per_shader_stage;
        check_storage_buffers(source, most)?;
        let pipeline = self.pipeline(source)?;
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.inner.as_entire_binding(),
            })
            .collect();
        let buffers = self.scoped(source.pass, 0, || {
            self.raw().create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(source.pass),
                layout: &pipeline.layout,
                entries: &entries,
            })
        })?;
        let workgroups = threads.div_ceil(u64::from(source.workgroup_size));
        let most = self.raw().limits().max_compute_workgroups_per_dimension;
        let workgroups = Workgroups::Known(fold(workgroups, most));
        Ok(Pass { pipeline, buffers, workgroups })
    }

    /// The pipeline of `source`, compiled once a source.
    fn pipeline(&self, source: &PassSource) -> Result<Arc<Pipeline>, GpuError> {
        self.require(source.real)?;
        let text = source.link()?;
        if let Some(pipeline) = self.pipelines().get(&text) {
            return Ok(Arc::clone(pipeline));
        }
        let pipeline = Arc::new(self.scoped(source.pass, 0, || self.compile(source, &text))?);
        self.pipelines().insert(text, Arc::clone(&pipeline));
        Ok(pipeline)
    }

    fn compile(&self, source: &PassSource, text: &str) -> Pipeline {
        let label = Some(source.pass);
        let entries: Vec<_> = (0..)
            .zip(&source.bindings)
            .map(|(number, binding)| layout_entry(number, binding.holds))
            .collect();
        let layout = self.raw().create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label,
            entries: &entries,
        });
        let pipeline_layout = self.raw().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let module = self.raw().create_shader_module(wgpu::ShaderModuleDescriptor {
            label,
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let pipeline = self.raw().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
        Pipeline { pipeline, layout }
    }
}

/// An error if a pass has more storage buffers than `most`.
fn check_storage_buffers(source: &PassSource, most: u32) -> Result<(), GpuError> {
    let is_storage = |binding: &&Binding| !matches!(binding.holds, Holds::Block(_));
    let needed = source.bindings.iter().filter(is_storage).count() as u32;
    if needed > most {
        let pass = source.pass.to_owned();
        return Err(GpuError::TooManyBuffers { pass, needed, available: most });
    }
    Ok(())
}

fn layout_entry(binding: u32, holds: Holds) -> wgpu::BindGroupLayoutEntry {
    let ty = match holds {
        Holds::Block(_) => wgpu::BufferBindingType::Uniform,
        Holds::Read(_) => wgpu::BufferBindingType::Storage { read_only: true },
        Holds::Write(_) => wgpu::BufferBindingType::Storage { read_only: false },
    };
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}

/// Workgroups along x and y: at least `workgroups` in all, and at most `most` along each. Shaders
/// flatten them again (`shaders/index.wgsl`).
fn fold(workgroups: u64, most: u32) -> [u32; 2] {
    let rows = workgroups.div_ceil(u64::from(most)).max(1);
    let columns = workgroups.div_ceil(rows);
    // Buffers are bounded far below most * most workgroups, so neither count is cut here.
    [columns, rows].map(|count| u32::try_from(count).unwrap_or(most))
}

#[cfg(test)]
mod tests {
    use super::{check_storage_buffers, fold};
    use crate::gpu::limits::limit_sources;
    use crate::gpu::{GpuError, Real};

    #[test]
    fn a_pass_with_too_many_storage_buffers_is_named() {
        // Two arrays and a parameter block, which is no storage buffer.
        let [_, source] = limit_sources(Real::F32);
        assert!(check_storage_buffers(&source, 2).is_ok());
        let error = check_storage_buffers(&source, 1).expect_err("two are needed");
        assert!(matches!(error, GpuError::TooManyBuffers { needed: 2, available: 1, .. }));
        assert!(error.to_string().contains("`arithmetic` needs 2 storage buffers"), "{error}");
    }

    #[test]
    fn folded_workgroups_cover_all_and_stay_within_the_limit() {
        for workgroups in [0, 1, 2, 65_535, 65_536, 65_537, 200_003, 16_777_216] {
            let [x, y] = fold(workgroups, 65_535).map(u64::from);
            assert!(x <= 65_535 && y <= 65_535);
            assert!(x * y >= workgroups && x * y < workgroups + y);
        }
    }
}
