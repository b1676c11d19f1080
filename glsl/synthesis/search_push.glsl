// What quilt_search and quilt_compare are told. Rust's side of it is SearchPush in
// src/synthesis/quilt_stages.rs.
layout(push_constant) uniform Push {
    uint output_width, output_height;
    uint sample_height;
    uint block_px, overlap_px;
    uint tileable;
    uint columns, rows;
    // The blocks of this dispatch are order[first_block ...].
    uint first_block;
    // Groups of positions are first_group ... of groups_per_block.
    uint first_group, groups_per_block;
    // In 1/10,000.
    uint tolerance;
    // Rows of `tile_bounds` that a block has.
    uint bound_rows;
    // Where the least errors of `quilt_aim` begin among the groups' minima.
    uint first_least;
} push;
