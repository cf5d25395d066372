// Nothing is listed.

fn note(place: u32) {}
