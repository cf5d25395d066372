// Evaluates the pair functions at given arguments, for comparison with their twins in f64.

@compute @workgroup_size(WORKGROUP_SIZE)
fn probe(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = flat_index(group, groups, lane);
    if i < arrayLength(&arguments) {
        let at = arguments[i];
        shape[i] = vec2<real>(kernel_shape(at.x), kernel_shape_dw_over_r(at.x));
        mean[i] = pair_mean(at.x, at.y);
    }
}
