// The places of a pass are all of a part: tiles that other parts reach are not listed.

fn front_place(i: u32) -> u32 {
    return part.first_site + i;
}

fn leave(site: u32) {}
