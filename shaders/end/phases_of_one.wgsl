// All places melt alike.

fn phases_of(place: u32) -> Phases {
    return Phases(
        of_words(MELTS, MELTS_REST),
        WIDTH,
        vec2<real>(SOLID_SLOPE, LIQUID_SLOPE),
        of_words(BEGINS, BEGINS_REST),
        of_words(ENDS, ENDS_REST),
    );
}
