// Tiles are listed, each once.

fn append(tile: u32) {
    if (atomicOr(&tiles[tile], APPENDED) & APPENDED) == 0u {
        let k = atomicAdd(&appended[0], 1u);
        atomicStore(&appended[1u + k], tile);
    }
}
