// One explicit Euler step of a part of a lattice, the report's (115).

@compute @workgroup_size(WORKGROUP_SIZE)
fn lattice_step(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let site = part.first_site + flat_index(group, groups, lane);
    if site < part.end_site {
        let own = own_value(site);
        let increment = step_size.over_reference * site_sum(site, own);
        advance(site - part.first_site, own, increment);
    }
}
