// By how much each potential changes with a change of the state; what does not change gets 0.

@compute @workgroup_size(WORKGROUP_SIZE)
fn potential_change(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < arrayLength(&after) {
        let changed = plus(potential_of(i, plus(content[i], change[i])), -potential_of(i, content[i]));
        after[i] = select(changed, exactly(real(0.0)), collapsed(change[i]) == 0.0);
    }
}
