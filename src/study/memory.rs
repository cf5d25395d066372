//! The memory that is free.

use sysinfo::System;

/// The part of the memory that is free which a scene may take.
pub(super) const SHARE: f64 = 0.8;

/// Memory that is free, bytes: that of the machine or of its control group, whichever has less.
pub(super) fn free_memory() -> u64 {
    let mut system = System::new();
    system.refresh_memory();
    // What a group's limit counts includes pages of files, which give way.
    let of_group =
        system.cgroup_limits().map(|limits| limits.total_memory.saturating_sub(limits.rss));
    system.available_memory().min(of_group.unwrap_or(u64::MAX))
}
