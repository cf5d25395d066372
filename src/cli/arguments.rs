//! Flags that several commands share.

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};

use super::CliError;
use crate::case::{self, Override, Scene};
use crate::solver::{BackendWish, MachineWish, PathWish, Precision};

/// Which case, and what is changed in it.
#[derive(Debug, Args)]
pub(super) struct CaseArguments {
    /// A case file, or the name of a shipped case (see `diffusph cases`)
    pub(super) case: String,
    /// Change a value of the case: `--set time.step=1000`, `--set operator.correction=moment`,
    /// `--set particles.fill.0.material=clay`. JSON if it parses, else a string, which a number
    /// reads as an expression
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// The time integrator: euler, heun, rkl2, tr_bdf2, steady, or auto for the cheapest that is
    /// accurate enough
    #[arg(long, value_name = "NAME")]
    method: Option<String>,
}

impl CaseArguments {
    /// Loads the case with every override applied.
    pub(super) fn load(&self) -> Result<Scene, CliError> {
        let overrides = self
            .changes()
            .iter()
            .map(|text| Override::parse(text))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(case::load(&self.case, &overrides)?)
    }

    /// What is changed in the case, as `path=value`.
    pub(super) fn changes(&self) -> Vec<String> {
        let method = self.method.iter().map(|method| format!("time.method={method}"));
        self.set.iter().cloned().chain(method).collect()
    }
}

/// Which machine.
#[derive(Debug, Args)]
pub(super) struct MachineArguments {
    /// Where to run: `auto` takes a real GPU if there is one, else the CPU; `gpu` also takes a
    /// software adapter
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendFlag,
    /// Part of the adapter's name, any case (see `diffusph devices`)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Where to run, and how.
#[derive(Debug, Args)]
pub(super) struct WayArguments {
    #[command(flatten)]
    machine: MachineArguments,
    /// The precision. The CPU path is f64. On a GPU, `compensated` keeps values in two words of
    /// f32; `auto` is f32 where every step adds more than f32 loses, else compensated, else f64
    #[arg(long, value_enum, default_value = "auto")]
    precision: PrecisionFlag,
    /// How neighbours are known: `lattice` takes a stencil wherever it holds, and stored rows
    /// elsewhere; `list` stored rows alone; `matrix-free`, on a GPU, searches for neighbours in
    /// every step and stores none; `auto` the fastest that there is memory for
    #[arg(long, value_enum, default_value = "auto")]
    path: PathFlag,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum BackendFlag {
    Auto,
    Cpu,
    Gpu,
}

/// A precision.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum PrecisionFlag {
    Auto,
    F32,
    Compensated,
    F64,
}

/// A path.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum PathFlag {
    Auto,
    List,
    Lattice,
    MatrixFree,
}

impl PrecisionFlag {
    /// The precision that is wanted, if one is.
    pub(super) fn wish(self) -> Option<Precision> {
        match self {
            Self::Auto => None,
            Self::F32 => Some(Precision::F32),
            Self::Compensated => Some(Precision::Compensated),
            Self::F64 => Some(Precision::F64),
        }
    }
}

impl PathFlag {
    /// The path that is wanted.
    pub(super) fn wish(self) -> PathWish {
        match self {
            Self::Auto => PathWish::Auto,
            Self::List => PathWish::List,
            Self::Lattice => PathWish::Lattice,
            Self::MatrixFree => PathWish::MatrixFree,
        }
    }
}

impl MachineArguments {
    /// The flags as a wish, in whatever precision.
    pub(super) fn wish(&self) -> MachineWish {
        MachineWish {
            backend: match self.backend {
                BackendFlag::Auto => BackendWish::Auto,
                BackendFlag::Cpu => BackendWish::Cpu,
                BackendFlag::Gpu => BackendWish::Gpu,
            },
            adapter: self.adapter.clone(),
            precision: None,
        }
    }
}

impl WayArguments {
    /// The path that is wanted.
    pub(super) fn path(&self) -> PathWish {
        self.path.wish()
    }

    /// The flags as another run takes them, on the backend that `auto` stands for here.
    pub(super) fn flags(&self, backend: &str) -> Vec<(String, String)> {
        let name = |value: Option<PossibleValue>| value.map(|of| of.get_name().to_owned());
        let all = [
            ("backend", Some(backend.to_owned())),
            ("adapter", self.machine.adapter.clone()),
            ("precision", name(self.precision.to_possible_value())),
            ("path", name(self.path.to_possible_value())),
        ];
        let given = all.into_iter().filter(|(_, value)| value.as_deref() != Some("auto"));
        given.filter_map(|(flag, value)| Some((flag.to_owned(), value?))).collect()
    }

    /// The flags as a wish.
    pub(super) fn wish(&self) -> MachineWish {
        MachineWish { precision: self.precision.wish(), ..self.machine.wish() }
    }
}
