//! An open device.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::pass::Pipeline;
use super::{Adapter, AdapterReport, GpuError, Pass, Real};

/// An open device. Clones share it.
#[derive(Clone, Debug)]
pub struct Device {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    device: wgpu::Device,
    queue: wgpu::Queue,
    report: AdapterReport,
    /// The first failure that no call could report: an asynchronous one, or the device's loss.
    failure: Arc<Mutex<Option<Failure>>>,
    /// Pipelines by final source.
    pipelines: Mutex<HashMap<String, Arc<Pipeline>>>,
}

#[derive(Clone, Debug)]
enum Failure {
    Lost(String),
    Refused(String),
}

/// Work given to the device, to wait for.
#[derive(Clone, Debug)]
pub struct Submission(wgpu::SubmissionIndex);

impl Device {
    /// Opens `adapter` with all that its limits allow.
    pub fn open(adapter: &Adapter) -> Result<Self, GpuError> {
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("diffusph"),
            required_features: adapter.inner.features() & wgpu::Features::SHADER_F64,
            required_limits: adapter.inner.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.inner.request_device(&descriptor))
            .map_err(|source| GpuError::Open { adapter: adapter.report().name.clone(), source })?;
        let failure = Arc::new(Mutex::new(None));
        let on_lost = Arc::clone(&failure);
        device.set_device_lost_callback(move |reason, message| {
            lock(&on_lost).get_or_insert(Failure::Lost(format!("{message} ({reason:?})")));
        });
        let on_error = Arc::clone(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            lock(&on_error).get_or_insert(Failure::Refused(error.to_string()));
        }));
        Ok(Self {
            inner: Arc::new(Inner {
                device,
                queue,
                report: adapter.report().clone(),
                failure,
                pipelines: Mutex::default(),
            }),
        })
    }

    /// What the adapter is and can do.
    pub fn report(&self) -> &AdapterReport {
        &self.inner.report
    }

    /// Largest storage buffer that a shader sees at once, bytes.
    pub fn max_binding_bytes(&self) -> u64 {
        let limits = self.inner.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }

    /// An error if shaders cannot use `real` here.
    pub fn require(&self, real: Real) -> Result<(), GpuError> {
        if real == Real::F64 && !self.inner.report.has_f64 {
            return Err(GpuError::MissingFeature {
                feature: "f64 in shaders",
                adapter: self.inner.report.name.clone(),
            });
        }
        Ok(())
    }

    /// Gives the passes to the device, in this order.
    ///
    /// They go into one compute pass, where each sees what the ones before it wrote: far cheaper
    /// than a submission each.
    pub fn submit<'a>(
        &self,
        passes: impl IntoIterator<Item = &'a Pass>,
    ) -> Result<Submission, GpuError> {
        let index = self.scoped("a submission", 0, || {
            let mut encoder = self.raw().create_command_encoder(&Default::default());
            let mut compute = encoder.begin_compute_pass(&Default::default());
            for pass in passes {
                pass.record(&mut compute);
            }
            drop(compute);
            self.queue().submit([encoder.finish()])
        })?;
        Ok(Submission(index))
    }

    /// Blocks until `submission` is done.
    pub fn wait(&self, submission: &Submission) -> Result<(), GpuError> {
        self.poll(Some(submission.0.clone()))
    }

    /// Blocks until everything submitted is done.
    pub fn wait_for_all(&self) -> Result<(), GpuError> {
        self.poll(None)
    }

    fn poll(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), GpuError> {
        let outcome = self.raw().poll(wgpu::PollType::Wait { submission_index, timeout: None });
        // The loss explains the failure of the wait, so it comes first.
        self.check()?;
        outcome?;
        Ok(())
    }

    /// An error if something failed behind the back of the calls so far.
    fn check(&self) -> Result<(), GpuError> {
        match lock(&self.inner.failure).clone() {
            None => Ok(()),
            Some(Failure::Lost(reason)) => Err(GpuError::Lost { reason }),
            Some(Failure::Refused(reason)) => {
                Err(GpuError::Refused { what: "earlier work".to_owned(), reason })
            }
        }
    }

    /// Runs `make`, turning what wgpu reports about it into an error on `what`.
    pub(super) fn scoped<T>(
        &self,
        what: &str,
        needed: u64,
        make: impl FnOnce() -> T,
    ) -> Result<T, GpuError> {
        let filters = [
            wgpu::ErrorFilter::Internal,
            wgpu::ErrorFilter::OutOfMemory,
            wgpu::ErrorFilter::Validation,
        ];
        let scopes = filters.map(|filter| self.raw().push_error_scope(filter));
        let made = make();
        let mut first = None;
        // Scopes close innermost first.
        for scope in scopes.into_iter().rev() {
            let error = pollster::block_on(scope.pop());
            first = first.or(error);
        }
        self.check()?;
        match first {
            None => Ok(made),
            Some(wgpu::Error::OutOfMemory { .. }) => {
                Err(GpuError::OutOfMemory { what: what.to_owned(), needed })
            }
            Some(error) => {
                Err(GpuError::Refused { what: what.to_owned(), reason: error.to_string() })
            }
        }
    }

    pub(super) fn raw(&self) -> &wgpu::Device {
        &self.inner.device
    }

    pub(super) fn queue(&self) -> &wgpu::Queue {
        &self.inner.queue
    }

    pub(super) fn pipelines(&self) -> MutexGuard<'_, HashMap<String, Arc<Pipeline>>> {
        lock(&self.inner.pipelines)
    }
}

/// Locks; a thread that panicked while it held the lock leaves nothing half-done behind here.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
