// No axis is periodic: neighbour cells end at the edge of the grid.

fn first_step(at: u32, cells: u32, periodic: bool) -> i32 {
    return -i32(min(at, 1u));
}

fn last_step(at: u32, cells: u32, periodic: bool) -> i32 {
    return i32(min(cells - 1u - at, 1u));
}

fn stepped(at: u32, step: i32, cells: u32) -> u32 {
    return u32(i32(at) + step);
}

fn nearest_image(difference: real, cells: u32, periodic: bool) -> real {
    return difference;
}

// The cell after a particle has moved by `carry` cells: the last one keeps what is beyond.
fn settled(at: u32, carry: i32, cells: u32, periodic: bool) -> u32 {
    return u32(clamp(i32(at) + carry, 0, i32(cells) - 1));
}

// How many cells its offset goes back.
fn settled_carry(at: u32, carry: i32, cells: u32, periodic: bool) -> i32 {
    return i32(settled(at, carry, cells, periodic)) - i32(at);
}

