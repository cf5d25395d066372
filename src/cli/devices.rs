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
    let mark = |has: bool| if has { "yes" } else { "no" };
    format!(
        "{}\n  {} device through {}, driver {}\n  f64 {}, subgroups {}, timestamps {}\n  buffers to \
         {}, bound to {}, {} storage buffers a shader\n  {} invocations and {} of shared memory a \
         workgroup\n",
        adapter.name,
        adapter.device_type,
        adapter.backend,
        adapter.driver,
        mark(adapter.has_f64),
        mark(adapter.has_subgroups),
        mark(adapter.has_timestamps),
        bytes(adapter.max_buffer_bytes),
        bytes(adapter.max_binding_bytes),
        adapter.max_storage_buffers,
        adapter.max_workgroup_invocations,
        bytes(u64::from(adapter.max_workgroup_memory_bytes)),
    )
}
