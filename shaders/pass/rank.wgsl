// Sorts the particles of each cell by index, so that a run repeats bit for bit: the place of each
// is the number of members with a smaller index.

@compute @workgroup_size(WORKGROUP_SIZE)
fn rank(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let place = flat_index(group, groups, lane);
    if place >= grid.particles {
        return;
    }
    let particle = scattered[place];
    let id = cell[particle];
    var smaller = 0u;
    for (var other = cell_start[id]; other < cell_start[id + 1u]; other++) {
        smaller += u32(scattered[other] < particle);
    }
    order[cell_start[id] + smaller] = particle;
}
