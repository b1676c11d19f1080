// The least bound of the error in each tile of TILE neighbouring positions, in an image of words: the bits of a float,
// or NO_BOUND where no position of the tile can be chosen. Tiles in raster order as of quilt_search. For shaders that
// have declared `tile_bounds`.

const uint NO_BOUND = 0xffffffffu;

// Words in a row of the image. A block has whole rows of its own; Rust's side of it is src/synthesis/prune.rs.
const uint BOUND_WORDS = 1024;

// Where the word of a tile lies, for the block at `slot` of a dispatch, whose blocks have `rows` rows each.
ivec2 bound_word(uint slot, uint rows, uint tile) {
    return ivec2(tile % BOUND_WORDS, slot * rows + tile / BOUND_WORDS);
}

// The largest bound, as a float, of a position that may be chosen when the least error is known to be `least` at most.
// The conversion may round down, by less than what is added.
float bound_limit(uint least, uint tolerance) {
    return float(threshold(least, tolerance)) * (1.0 + 1.0 / 1048576.0);
}
