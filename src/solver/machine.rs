//! Where a run takes place.

use super::{Precision, SolverError};
use crate::gpu::{self, Adapter, Device};

/// What the user asks for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MachineWish {
    /// The backend.
    pub backend: BackendWish,
    /// Part of the adapter's name, any case.
    pub adapter: Option<String>,
    /// The precision; `None` takes the backend's own.
    pub precision: Option<Precision>,
}

/// Which backend is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackendWish {
    /// A real GPU if there is one, else the CPU path.
    #[default]
    Auto,
    /// The CPU path.
    Cpu,
    /// A GPU; a software adapter where there is no real one.
    Gpu,
}

/// A machine, ready.
#[derive(Debug)]
pub enum Machine {
    /// The CPU path, f64.
    Cpu,
    /// A GPU.
    Gpu {
        /// The opened device.
        device: Device,
        /// The precision of state and arithmetic.
        precision: Precision,
    },
}

/// Which kind of machine, without the machine: all that a plan depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MachineKind {
    /// The CPU path, f64.
    Cpu,
    /// A GPU with this precision.
    Gpu(Precision),
}

impl MachineKind {
    /// The name in flags and reports.
    pub fn backend_name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Gpu(_) => "gpu",
        }
    }

    /// The precision of state and arithmetic.
    pub fn precision(self) -> Precision {
        match self {
            Self::Cpu => Precision::F64,
            Self::Gpu(precision) => precision,
        }
    }
}

impl Machine {
    /// Finds and opens the machine that `wish` asks for. The text says why a real GPU was passed
    /// over, if it was.
    ///
    /// # Errors
    /// An adapter that does not exist, a precision that the machine does not have.
    pub fn open(wish: &MachineWish) -> Result<(Self, Option<String>), SolverError> {
        let named = wish.adapter.as_deref();
        let (adapter, may_fall_back) = match (wish.backend, named) {
            (BackendWish::Cpu, Some(name)) => {
                return Err(SolverError::AdapterOnCpu { name: name.to_owned() });
            }
            (BackendWish::Cpu, None) => (None, false),
            (BackendWish::Gpu, _) => (gpu::choose(named, true)?, false),
            // A name that is given is meant, software or not.
            (BackendWish::Auto, Some(_)) => (gpu::choose(named, true)?, false),
            (BackendWish::Auto, None) => (gpu::choose(None, false)?, true),
        };
        let opened = adapter.map(|adapter| Self::open_gpu(&adapter, wish.precision)).transpose();
        match (opened, wish.precision) {
            (Ok(Some(machine)), _) => Ok((machine, None)),
            (Ok(None), None | Some(Precision::F64)) => Ok((Self::Cpu, None)),
            (Ok(None), Some(precision)) => Err(SolverError::PrecisionOnCpu { precision }),
            (Err(error), None) if may_fall_back => {
                Ok((Self::Cpu, Some(format!("took the CPU path: {error}"))))
            }
            (Err(error), _) => Err(error),
        }
    }

    fn open_gpu(adapter: &Adapter, precision: Option<Precision>) -> Result<Self, SolverError> {
        let device = Device::open(adapter)?;
        let precision = precision.unwrap_or(Precision::F32);
        device.require(precision.real())?;
        Ok(Self::Gpu { device, precision })
    }

    /// Every precision that it has.
    pub fn precisions(&self) -> Vec<Precision> {
        match self {
            Self::Cpu => vec![Precision::F64],
            Self::Gpu { device, .. } => {
                let has = |precision: &Precision| device.require(precision.real()).is_ok();
                Precision::ALL.into_iter().filter(has).collect()
            }
        }
    }

    /// The same machine in another of its precisions.
    #[must_use]
    pub fn in_precision(&self, precision: Precision) -> Self {
        match self {
            Self::Cpu => Self::Cpu,
            Self::Gpu { device, .. } => Self::Gpu { device: device.clone(), precision },
        }
    }

    /// Whether its buffers lie in the memory that programs use.
    pub fn shares_memory(&self) -> bool {
        match self {
            Self::Cpu => true,
            Self::Gpu { device, .. } => {
                ["software", "integrated"].contains(&device.report().device_type)
            }
        }
    }

    /// The largest field that it takes, bytes; none where only memory limits it.
    pub fn most_field_bytes(&self) -> Option<u64> {
        match self {
            Self::Cpu => None,
            Self::Gpu { device, .. } => Some(device.max_binding_bytes()),
        }
    }

    /// Which kind it is.
    pub fn kind(&self) -> MachineKind {
        match self {
            Self::Cpu => MachineKind::Cpu,
            Self::Gpu { precision, .. } => MachineKind::Gpu(*precision),
        }
    }

    /// The adapter's name; `None` on the CPU path.
    pub fn adapter(&self) -> Option<&str> {
        match self {
            Self::Cpu => None,
            Self::Gpu { device, .. } => Some(&device.report().name),
        }
    }
}
