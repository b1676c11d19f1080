// Which positions of a search are left to be compared: a bit each in an image of words, a byte to a tile of TILE
// neighbours, tiles in raster order as of quilt_search. For shaders that have declared `survivors`.

// Words in a row of the image. A block has whole rows of its own; Rust's side of it is src/synthesis/prune.rs.
const uint SURVIVOR_WORDS = 1024;

// Where the word of a tile lies, for the block at `slot` of a dispatch, whose blocks have `rows` rows each.
ivec2 survivor_word(uint slot, uint rows, uint tile) {
    uint word = tile / 4;
    return ivec2(word % SURVIVOR_WORDS, slot * rows + word / SURVIVOR_WORDS);
}

// The first bit of a tile in its word.
uint survivor_bit(uint tile) {
    return 8 * (tile % 4);
}
