// All places melt alike.

fn front_of(place: u32) -> Front {
    return front_at(0u);
}

fn choose_front(place: u32) {}

fn shares_front(place: u32) -> bool {
    return true;
}
