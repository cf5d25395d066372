// What melts at one temperature is listed: potentials do not rise in its segment, whose start is a solid still.
// Once its flows are corrected it may melt no more, which those who read the list see for themselves.

fn note(place: u32, segment: u32, enthalpy: real) {
    if curve[2u * segment + 1u].x == 0.0 && enthalpy > curve[2u * segment].x {
        append(place / TILE);
    }
}
