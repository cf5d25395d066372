// The same for the sites of a part of a lattice where more than the stencil acts, and what held
// particles and walls give there.

@compute @workgroup_size(WORKGROUP_SIZE)
fn exception_combine(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = part.first_exception + flat_index(group, groups, lane);
    if row >= part.end_exception {
        return;
    }
    let site = exception[row].x;
    let own = own_value(site);
    let sum = row_sum(row, site, own);
    let rate = sum + wall_rate(row, collapsed(own));
    after[site - part.first_site] = combined(own, select(rate, real(0.0), is_held(row)));
    if is_held(row) {
        record_given(exception[row].z, rate_among_held(row) - sum);
    }
    if has_wall(row) {
        record_given(factors.held + wall_slot(row), inflow(row, collapsed(own)));
    }
}
