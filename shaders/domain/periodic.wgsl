// Some axes are periodic: there the cells wrap round, and the nearest image counts.

fn first_step(at: u32, cells: u32, periodic: bool) -> i32 {
    if periodic {
        // Of one or two cells each is visited once; the nearest image does the rest.
        return select(0, -1, cells > 2u);
    }
    return -i32(min(at, 1u));
}

fn last_step(at: u32, cells: u32, periodic: bool) -> i32 {
    if periodic {
        return select(0, 1, cells > 1u);
    }
    return i32(min(cells - 1u - at, 1u));
}

fn wrapped(at: i32, cells: i32) -> u32 {
    return u32((at % cells + cells) % cells);
}

fn stepped(at: u32, step: i32, cells: u32) -> u32 {
    return wrapped(i32(at) + step, i32(cells));
}

fn nearest_image(difference: real, cells: u32, periodic: bool) -> real {
    if periodic {
        return difference - real(cells) * round(difference / real(cells));
    }
    return difference;
}

// The cell after a particle has moved by `carry` cells.
fn settled(at: u32, carry: i32, cells: u32, periodic: bool) -> u32 {
    if periodic {
        return wrapped(i32(at) + carry, i32(cells));
    }
    return u32(clamp(i32(at) + carry, 0, i32(cells) - 1));
}

// How many cells its offset goes back.
fn settled_carry(at: u32, carry: i32, cells: u32, periodic: bool) -> i32 {
    if periodic {
        return carry;
    }
    return i32(settled(at, carry, cells, periodic)) - i32(at);
}

