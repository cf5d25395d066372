// Each place has the curve of its material, whose segments begin at `curve_start`.

fn curve_bounds(place: u32) -> vec2<u32> {
    let material = curve_of[place];
    return vec2<u32>(curve_start[material], curve_start[material + 1u]);
}

