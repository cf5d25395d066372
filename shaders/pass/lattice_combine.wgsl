// A share of each value of a part of a lattice and of its rate, as if no particle were held.

@compute @workgroup_size(WORKGROUP_SIZE)
fn lattice_combine(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let site = part.first_site + flat_index(group, groups, lane);
    if site < part.end_site {
        let own = own_value(site);
        after[site - part.first_site] = combined(own, site_sum(site, own));
    }
}
