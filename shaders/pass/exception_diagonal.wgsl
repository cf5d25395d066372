// The factor of a site's own value in its rate, for the sites of a part of a lattice where more than the
// stencil acts, but for what sources add in proportion to the value.

@compute @workgroup_size(WORKGROUP_SIZE)
fn exception_diagonal(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = part.first_exception + flat_index(group, groups, lane);
    if row < part.end_exception {
        let site = exception[row].x;
        after[site - part.first_site] = exactly(row_sum(row, site, own_value(site)));
    }
}
