// Of the state, whose enthalpies potentials tell unless they melt: a solid is of the first segment of its curve, a liquid
// of the last, and both of them are straight.

fn local_at(place: u32, is_changed: bool) -> Local {
    let potential = state[place];
    let above_melting = collapsed(potential - phases_of(place).melts);
    if above_melting == 0.0 {
        return local_of(place, content[place]);
    }
    let bounds = curve_bounds(place);
    let segment = select(bounds.x, bounds.y - 1u, above_melting > 0.0);
    let base = curve[2u * segment].zw;
    let shape = curve[2u * segment + 1u];
    let heat = thermal[segment];
    let above = plus(potential, of_words(-base.x, -base.y));
    return Local(
        plus(of_words(heat.x, heat.y), (heat.z / shape.x) * above),
        potential,
        shape.z,
    );
}

fn shortage(row: vec4<u32>) -> real {
    return seam_sum(row, false);
}
