// What the stages that prune a search share. Rust's side of it is src/synthesis/prune.rs.

// Texels of eight coordinates that a position has.
layout(constant_id = 0) const uint TEXELS = 8;
const uint COORDINATES = 8 * TEXELS;
// Both sides of a block have up to six, and two parts of them one more each.
const uint MAX_TEXELS = 14;
