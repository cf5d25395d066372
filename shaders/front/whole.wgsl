// The state is one buffer.

fn potential_at(place: u32) -> Value {
    return before[place];
}

fn content_at(place: u32) -> Value {
    return content[place];
}
