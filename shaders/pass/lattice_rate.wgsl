// The rate of change of a part of a lattice, a reference step, as if no particle were held.

@compute @workgroup_size(WORKGROUP_SIZE)
fn lattice_rate(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let site = part.first_site + flat_index(group, groups, lane);
    if site < part.end_site {
        after[site - part.first_site] = exactly(site_sum(site, own_value(site)));
    }
}
