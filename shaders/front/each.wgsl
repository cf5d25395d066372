// Each place melts as its material does.

var<private> chosen: u32;

fn front_of(place: u32) -> Front {
    return front_at(curve_of[place]);
}

fn choose_front(place: u32) {
    chosen = curve_of[place];
}

fn shares_front(place: u32) -> bool {
    return curve_of[place] == chosen;
}
