//! Where a run takes place.

use super::gpu::SelfTest;
use super::gpu::passes::self_test;
use super::{Foreseen, Precision, SolverError};
use crate::gpu::{self, Adapter, Device};
use crate::model::Problem;

/// What the user asks for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MachineWish {
    /// The backend.
    pub backend: BackendWish,
    /// Part of the adapter's name, any case.
    pub adapter: Option<String>,
    /// The precision; `None` leaves it to the backend and the scene.
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

/// A machine that is ready for a scene.
#[derive(Debug)]
pub struct Opened {
    /// The machine, in the precision that it will run in.
    pub machine: Machine,
    /// Why in this precision, where the scene decides.
    pub why_precision: Option<String>,
    /// What the user should know before the run.
    pub warnings: Vec<String>,
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
    /// Finds and opens the machine that `wish` asks for, a GPU in f32 where `wish` leaves that open.
    /// The text says why a real GPU was passed over, if it was.
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
        has_precision(&device, precision)?;
        Ok(Self::Gpu { device, precision })
    }

    /// The machine that `wish` asks for, ready for `problem`. Where `wish` leaves the precision of a
    /// GPU open, that is f32 if rounding does no harm to the run (see [`Foreseen`]), else compensated,
    /// else f64; where the device has neither, the CPU, if `wish` leaves that open too.
    ///
    /// # Errors
    /// As [`Machine::open`]; [`SolverError::NothingBetter`].
    pub fn open_for(wish: &MachineWish, problem: &Problem) -> Result<Opened, SolverError> {
        let (machine, passed_over) = Self::open(wish)?;
        let mut opened =
            Opened { machine, why_precision: None, warnings: passed_over.into_iter().collect() };
        let Self::Gpu { device, .. } = &opened.machine else {
            return Ok(opened);
        };
        let harm = Foreseen::of(problem).harm();
        match (wish.precision, harm) {
            (None, None) => {
                opened.why_precision = Some("f32 keeps what the steps add".to_owned());
            }
            (None, Some(harm)) => match better_than_f32(device)? {
                Better::Has(precision, beside) => {
                    opened.why_precision = Some(harm + &beside);
                    opened.machine = opened.machine.in_precision(precision);
                }
                Better::None(fault) => {
                    if wish.backend != BackendWish::Auto || wish.adapter.is_some() {
                        return Err(SolverError::NothingBetter { harm, fault });
                    }
                    let why = format!("{harm}; the GPU has no f64, and {fault}");
                    opened.warnings.push(format!("took the CPU path: {why}"));
                    opened.machine = Self::Cpu;
                }
            },
            (Some(Precision::F32), Some(harm)) => {
                opened.warnings.push(format!("--precision f32: {harm}"));
            }
            (Some(_), _) => {}
        }
        Ok(opened)
    }

    /// Every precision that it has.
    pub fn precisions(&self) -> Vec<Precision> {
        match self {
            Self::Cpu => vec![Precision::F64],
            Self::Gpu { device, .. } => {
                let has = |precision: &Precision| has_precision(device, *precision).is_ok();
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

/// Refuses a precision that `device` does not have.
fn has_precision(device: &Device, precision: Precision) -> Result<(), SolverError> {
    device.require(precision.real())?;
    let fault = match precision {
        Precision::Compensated => SelfTest::run(device, &self_test())?.fault(),
        Precision::F32 | Precision::F64 => None,
    };
    fault.map_or(Ok(()), |fault| Err(SolverError::NotCompensated { fault }))
}

/// What a device has that is better than f32.
enum Better {
    /// A precision, with what is to be said beside the reason.
    Has(Precision, String),
    /// Nothing, since compensated sums have this fault.
    None(String),
}

fn better_than_f32(device: &Device) -> Result<Better, SolverError> {
    let fault = match has_precision(device, Precision::Compensated) {
        Ok(()) => return Ok(Better::Has(Precision::Compensated, String::new())),
        Err(SolverError::NotCompensated { fault }) => fault,
        Err(error) => return Err(error),
    };
    Ok(match device.require(Precision::F64.real()) {
        Ok(()) => Better::Has(Precision::F64, format!("; not compensated: {fault}")),
        Err(_) => Better::None(fault),
    })
}
