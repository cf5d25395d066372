// What fronts change of a step of the sites of a part of a lattice where more than the stencil acts.

@compute @workgroup_size(WORKGROUP_SIZE)
fn exception_front(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = part.first_exception + flat_index(group, groups, lane);
    if row >= part.end_exception {
        return;
    }
    let site = exception[row].x;
    let local = site - part.first_site;
    if !is_near(local) || !begin(site) {
        return;
    }
    let increment = step_size.over_reference * row_sum(row, site, own_value(site));
    if is_held(row) {
        record_exchange(row, increment, real(0.0));
        keep_listed(local);
    } else {
        correct(local, increment);
    }
}
