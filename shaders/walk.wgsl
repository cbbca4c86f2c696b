// What walks through a hierarchy share.

// Member order is checked against src/gpu/layout.rs by a test.
struct Walk {
    n_nodes: u32,
    // Picture column and row of the tile's first pixel.
    first_x: u32,
    first_y: u32,
    cell_shift: u32,
}

@group(0) @binding(next) var<uniform> walk: Walk;

fn texel(index: u32) -> vec2u {
    return vec2u(index & ((1u << ROW_BITS) - 1u), index >> ROW_BITS);
}

// An upper bound of t from a lower bound of 1 / t; beyond every node for 0 and below.
fn t_bound(nearness: Real) -> Real {
    return T_ROOM / max(nearness, LEAST_NEARNESS);
}

// What a walk that got to the node `at` has found, or undecided: a device in software may stop a long walk.
fn unless_stopped(nearest: Nearest, at: u32) -> Nearest {
    let is_stopped = at < walk.n_nodes;
    return Nearest(
        select(nearest.low, 0.0, is_stopped),
        nearest.high,
        nearest.second_high,
        select(nearest.id, UNDECIDED, is_stopped),
    );
}
