// Tiles are listed, each once. A list begins with how many workgroups go through it, along x, y and z: one at least, since
// the first empties another list too. Then comes its length, and then the tiles.

fn append(tile: u32) {
    if (atomicOr(&tiles[tile], APPENDED) & APPENDED) != 0u {
        return;
    }
    let k = atomicAdd(&appended[LIST_LENGTH], 1u);
    atomicStore(&appended[LIST_LENGTH + 1u + k], tile);
    let workgroup = k / TILES_OF_WORKGROUP;
    if workgroup == 0u || k % TILES_OF_WORKGROUP != 0u {
        return;
    }
    if workgroup < MOST_WORKGROUPS {
        atomicAdd(&appended[0], 1u);
    }
    if workgroup % MOST_WORKGROUPS == 0u {
        atomicAdd(&appended[1], 1u);
    }
}
