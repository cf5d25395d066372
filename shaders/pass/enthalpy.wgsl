// Adds to each enthalpy what a step has added to its potential as if it were the state, and writes the
// potential that comes of it.

@compute @workgroup_size(WORKGROUP_SIZE)
fn enthalpy(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < arrayLength(&after) {
        let now = plus(content[i], plus(after[i], -before[i]));
        content[i] = now;
        after[i] = potential_of(i, now);
        note(i, collapsed(now));
    }
}
