// What the stages that prune a search share: the strips of a block, and constants of the pipelines.
// Rust's side of it is src/synthesis/prune.rs.

const uint LEFT = 0;
const uint TOP = 1;
const uint STRIPS = 2;

// Layers of four coordinates that a strip has: its projections, what they leave out, and its squared length.
layout(constant_id = 0) const uint LAYERS = 8;
const uint DIRECTIONS = 4 * LAYERS - 3;
