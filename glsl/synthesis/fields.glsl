// Which parts of a block are painted already. Its overlaps cut a block into 3 x 3 fields, and a field is painted if any
// neighbour that reaches into it is placed. Bit 3 * band + field of a set of fields. For shaders that have declared
// `blocks` and a block of push constants with columns, rows, block_px, overlap_px, tileable.

// Whether the neighbour `dx`, `dy` blocks away (-1, 0 or 1) is placed.
bool placed(int row, int col, int dy, int dx) {
    ivec2 grid = ivec2(push.columns, push.rows);
    ivec2 at = ivec2(col + dx, row + dy);
    if (push.tileable != 0) {
        at = (at + grid) % grid;
    } else if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, grid))) {
        return false;
    }
    return blocks[at.y * grid.x + at.x].state == STATE_PLACED;
}

uint painted_fields(uint index) {
    int row = int(index / push.columns);
    int col = int(index % push.columns);
    uint fields = 0;
    for (int dy = -1; dy <= 1; dy++) {
        for (int dx = -1; dx <= 1; dx++) {
            if ((dx != 0 || dy != 0) && placed(row, col, dy, dx)) {
                // A neighbour straight above reaches into all three fields of the top band, and so on.
                uint across = dx < 0 ? 1u : dx > 0 ? 4u : 7u;
                uint down = dy < 0 ? 1u : dy > 0 ? 64u : 73u;
                fields |= across * down;
            }
        }
    }
    return fields;
}

// The field of the block's pixel at `dx`, `dy`.
uint field_of(Block block, uint dx, uint dy) {
    uint overlap = push.overlap_px;
    uint right = push.tileable != 0 ? block.width - overlap : push.block_px - overlap;
    uint below = push.tileable != 0 ? block.height - overlap : push.block_px - overlap;
    uint across = dx < overlap ? 0 : dx < right ? 1 : 2;
    uint down = dy < overlap ? 0 : dy < below ? 1 : 2;
    return 1u << (3 * down + across);
}
