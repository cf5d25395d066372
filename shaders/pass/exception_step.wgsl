// One explicit Euler step of the sites of a part of a lattice where more than the stencil acts.

@compute @workgroup_size(WORKGROUP_SIZE)
fn exception_step(
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
    let step = step_size.over_reference;
    let sum = row_sum(row, site, own);
    let rate = sum + wall_rate(row, collapsed(own));
    record_inflow(row, collapsed(own), step);
    if is_held(row) {
        record_exchange(row, step * sum, step);
        keep(site - part.first_site, own);
    } else {
        advance(site - part.first_site, own, step * rate);
    }
}
