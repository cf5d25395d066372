// Each place melts as its material does. `material_phases` has two vectors for each: the potential of melting, as the sum
// of two numbers, and the slopes of a solid and of a liquid; and where melting begins and ends, each as the sum of two
// numbers. What does not melt is further below that potential than anything gets.

fn phases_of(place: u32) -> Phases {
    let material = curve_of[place];
    let melts = material_phases[2u * material];
    let ends = material_phases[2u * material + 1u];
    return Phases(
        of_words(melts.x, melts.y),
        ROUNDINGS * abs(melts.x),
        melts.zw,
        of_words(ends.x, ends.y),
        of_words(ends.z, ends.w),
    );
}
