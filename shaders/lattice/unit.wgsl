// A state that is 1 at the site whose own value was last asked for and 0 at every other: the sum
// there is the diagonal.

var<private> unit_site: u32;

fn value_at(site: u32) -> Value {
    return exactly(select(real(0.0), real(1.0), site == unit_site));
}

fn own_value(site: u32) -> Value {
    unit_site = site;
    return exactly(real(1.0));
}

