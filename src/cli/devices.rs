//! `diffusph devices`: the adapters of this machine.

use clap::Args;

use super::{CliError, print, print_json};
use crate::gpu::{self, AdapterReport};
use crate::report::format::bytes;
use crate::solver::SolverError;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  diffusph devices --json")]
pub(super) struct Arguments {
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn devices(arguments: &Arguments) -> Result<(), CliError> {
    let adapters = gpu::adapters();
    let auto = gpu::choose(None, false).map_err(SolverError::from)?;
    let auto = auto.map(|adapter| adapter.report().name.clone());
    if arguments.json {
        return print_json(&serde_json::json!({ "adapters": adapters, "auto": auto }));
    }
    for adapter in &adapters {
        print(describe(adapter))?;
    }
    if adapters.is_empty() {
        print("no adapter: install a Vulkan driver to use `--backend gpu`")?;
    }
    print(match auto {
        Some(name) => format!("--backend auto takes {name}"),
        None => "--backend auto takes the CPU path (no real GPU)".to_owned(),
    })
}

fn describe(adapter: &AdapterReport) -> String {
    format!("{adapter:?} {}", bytes(0))
}
