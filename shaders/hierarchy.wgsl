// Each ray walks through the footprints alone, as src/gpu/before/alone.rs does with Footprints::visit of
// src/tree/footprints.rs.

//#if spheres
// Ids of the spheres that are not in the hierarchy.
@group(0) @binding(next) var<storage, read> rest_ids: array<u32>;

fn sphere_id(index: u32) -> u32 {
    return rest_ids[index];
}
//#end
// Textures, whose texels a software device loads for all lanes at once also within a loop: from
// storage buffers the walk takes some hundred times as long there.
@group(0) @binding(next) var nodes: texture_2d<u32>;
// Twin of SphereFar in src/kernel/certified/records.rs, two texels each.
@group(0) @binding(next) var far_spheres: texture_2d<u32>;

fn cell_of(pixel: vec2u) -> u32 {
    let column = (walk.first_x + pixel.x) >> walk.cell_shift;
    let row = (walk.first_y + pixel.y) >> walk.cell_shift;
    return column | row << 16u;
}

// No difference of columns or rows is negative.
fn covers(node: vec4u, cell: u32) -> bool {
    return (((cell | BORROW) - node.x) & (node.y - cell) & BORROW) == BORROW;
}

fn nearest_far(ray: Ray, cell: u32, listed: Nearest) -> Nearest {
    var nearest = listed;
    var t_max = t_bound(ray.a * nearest.low);
    var at = 0u;
    while at < walk.n_nodes {
        // A lane that has found a sphere waits until the others have, and all test theirs at once.
        var place = NO_PLACE;
        while at < walk.n_nodes && place == NO_PLACE {
            let node = textureLoad(nodes, texel(at), 0);
            let is_leaf = (node.w & IS_LEAF) != 0u;
            let is_seen = covers(node, cell) & (bitcast<f32>(node.z) <= t_max);
            place = select(NO_PLACE, node.w & ~IS_LEAF, is_seen & is_leaf);
            at = select(node.w, at + 1u, is_seen | is_leaf);
        }
        let is_found = place != NO_PLACE;
        let index = 2u * select(0u, place, is_found);
        let first = textureLoad(far_spheres, texel(index), 0);
        let second = textureLoad(far_spheres, texel(index + 1u), 0);
        let center_inner2 = bitcast<vec4f>(first);
        let outer2_q = bitcast<vec2f>(second.xy);
        //#if point
        let root =
            far_nearness(ray, center_inner2.xyz, center_inner2.w, outer2_q.x, outer2_q.y);
        let low = select(0.0, root.low * FAR_NARROWER, is_found);
        //#else
        let l = center_inner2.xyz - ray.origin;
        let root = parallel_nearness(ray, l, center_inner2.w, outer2_q.x, outer2_q.y);
        let low = select(0.0, root.low, is_found);
        //#end
        let high = select(0.0, root.high, is_found);
        nearest = nearer(nearest, Nearness(low, high), second.z);
        t_max = t_bound(ray.a * nearest.low);
    }
    return unless_stopped(nearest, at);
}
