// What fronts change of a step of a part of a lattice, but for its exceptions; or lists the tiles where they may, beside
// exceptions too.

@compute @workgroup_size(WORKGROUP_SIZE)
fn lattice_front(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let site = front_place(flat_index(group, groups, lane));
    if site >= part.end_site {
        return;
    }
    leave(site);
    let local = site - part.first_site;
    if is_left_out(local) || !begin(site) {
        return;
    }
    let sum = site_sum(site, own_value(site));
    correct(local, step_size.over_reference * sum);
}
