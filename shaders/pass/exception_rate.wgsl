// The rate of change of the sites of a part of a lattice where more than the stencil acts, a
// reference step; 0 for held ones.

@compute @workgroup_size(WORKGROUP_SIZE)
fn exception_rate(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = part.first_exception + flat_index(group, groups, lane);
    if row < part.end_exception {
        let site = exception[row].x;
        let own = own_value(site);
        let rate = row_sum(row, site, own) + wall_rate(row, collapsed(own));
        after[site - part.first_site] = exactly(select(rate, real(0.0), is_held(row)));
    }
}
