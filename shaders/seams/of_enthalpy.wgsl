// What a particle is like at an enthalpy. `thermal` has for each segment of a curve the temperature where it begins, as the
// sum of two numbers, and how it rises.

fn local_of(place: u32, enthalpy: Value) -> Local {
    let segment = segment_at(place, collapsed(enthalpy));
    let above = above_start(segment, enthalpy);
    let heat = thermal[segment];
    let shape = curve[2u * segment + 1u];
    return Local(
        plus(of_words(heat.x, heat.y), heat.z * above),
        potential_in(segment, above),
        shape.z + shape.w * collapsed(above),
    );
}
