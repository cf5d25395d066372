//! Where a study runs.

use sysinfo::{CpuRefreshKind, RefreshKind, System};

use crate::report::study::StudyMachine;
use crate::solver::Machine;

/// What reports say of this machine and of `machine`, which runs the settings.
pub fn study_machine(machine: &Machine) -> StudyMachine {
    let what = RefreshKind::nothing().with_cpu(CpuRefreshKind::nothing());
    let system = System::new_with_specifics(what);
    let brand = system.cpus().first().map(|cpu| cpu.brand().trim().to_owned());
    StudyMachine {
        processor: brand.filter(|name| !name.is_empty()).unwrap_or("unknown processor".to_owned()),
        threads: rayon::current_num_threads(),
        backend: machine.kind().backend_name().to_owned(),
        adapter: machine.adapter().map(str::to_owned),
    }
}
