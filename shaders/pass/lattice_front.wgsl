// What fronts change of a step of a part of a lattice, but for its exceptions.

@compute @workgroup_size(WORKGROUP_SIZE)
fn lattice_front(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let site = part.first_site + flat_index(group, groups, lane);
    if site >= part.end_site {
        return;
    }
    let local = site - part.first_site;
    let is_exception = (atomicLoad(&near[local]) & EXCEPTION) != 0u;
    if is_exception || !begin(site, local) {
        return;
    }
    let sum = site_sum(site, own_value(site));
    after[local] = advanced(after[local], step_size.over_reference * sum);
}
