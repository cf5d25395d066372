// What flows to and from what melts beside what the operator has (`Fronts` in src/model/operator/fronts.rs):
// a sum over neighbours whose values are the flows over the weights, with 0 as the place's own.

var<private> own_front: Front;
var<private> own_melts: bool;
// Of what melts how much more flows to it, in parts: from a liquid neighbour and from a solid one.
var<private> own_excess: vec2<real>;
// Potential above that of the front.
var<private> own_above: real;

fn value_at(other: u32) -> Value {
    let above = above_front(own_front, potential_at(other));
    let other_may_melt = may_melt(above);
    // Most of what is looked at does not melt, beside what does not either.
    if !(own_melts || other_may_melt) || !shares_front(other) {
        return exactly(real(0.0));
    }
    var enthalpy = real(0.0);
    var other_melts = false;
    if other_may_melt {
        enthalpy = collapsed(content_at(other));
        other_melts = is_melting(own_front, enthalpy);
    }
    if other_melts == own_melts {
        return exactly(real(0.0));
    }
    if own_melts {
        return exactly(select(own_excess.x, own_excess.y, above < 0.0) * above);
    }
    return exactly(-front_excess(own_front, enthalpy, own_above < 0.0) * own_above);
}

fn own_value(place: u32) -> Value {
    return exactly(real(0.0));
}

// Whether others see to a place.
fn is_left_out(local: u32) -> bool {
    return (atomicLoad(&tiles[local / TILE]) >> (local % TILE) & 1u) != 0u;
}

// Whether a sum is wanted of a place: 0 comes of it where nothing melts around.
fn begin(place: u32) -> bool {
    own_front = front_of(place);
    choose_front(place);
    let enthalpy = collapsed(enthalpy_at(place));
    own_melts = is_melting(own_front, enthalpy);
    own_excess = vec2<real>(
        front_excess(own_front, enthalpy, false),
        front_excess(own_front, enthalpy, true),
    );
    own_above = above_front(own_front, potential_at(place));
    return true;
}

// What is held goes on melting if it does.
fn keep_listed(i: u32) {
    if own_melts {
        note(i);
    }
}
