// Adds a change to each enthalpy, and writes the potential that comes of it.

@compute @workgroup_size(WORKGROUP_SIZE)
fn enthalpy_add(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < arrayLength(&after) {
        write_enthalpy(i, plus(content[i], change[i]));
    }
}
