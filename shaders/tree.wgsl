// Each ray of a list walks through the boxes of the tree alone, as src/gpu/before/in_space.rs does.

// Textures, as in hierarchy.wgsl: of a box, two texels (BoxNode in src/tree/flat.rs), and behind the boxes
// one for each sphere that is not in the tree, with its id.
@group(0) @binding(next) var nodes: texture_2d<u32>;
// SphereCertified, three texels each.
@group(0) @binding(next) var tree_spheres: texture_2d<u32>;

//#if spheres
fn sphere_id(index: u32) -> u32 {
    return textureLoad(nodes, texel(2u * walk.n_nodes + index), 0).x;
}
//#end

fn tree_sphere(place: u32) -> SphereCertified {
    let first = bitcast<vec4f>(textureLoad(tree_spheres, texel(3u * place), 0));
    let second = bitcast<vec4f>(textureLoad(tree_spheres, texel(3u * place + 1u), 0));
    let third = bitcast<vec4f>(textureLoad(tree_spheres, texel(3u * place + 2u), 0));
    return SphereCertified(
        first.xyz, first.w, second.xyz, second.w, third.x, third.y, third.z, third.w);
}

fn nearest_in_tree(ray: Ray, listed: Nearest) -> Nearest {
    let slabs = slabs_of(ray.origin, ray.direction, LEAST_SLACK);
    var nearest = listed;
    var t_max = t_bound(ray.a * nearest.low);
    var at = 0u;
    while at < walk.n_nodes {
        // A lane that has found a sphere waits until the others have, and all test theirs at once.
        var place = NO_PLACE;
        var id = 0u;
        while at < walk.n_nodes && place == NO_PLACE {
            let low = textureLoad(nodes, texel(2u * at), 0);
            let high = textureLoad(nodes, texel(2u * at + 1u), 0);
            let is_leaf = (low.w & IS_LEAF) != 0u;
            let is_met = meets(slabs, bitcast<vec3f>(low.xyz), bitcast<vec3f>(high.xyz), t_max);
            place = select(NO_PLACE, low.w & ~IS_LEAF, is_met & is_leaf);
            id = high.w;
            at = select(low.w, at + 1u, is_met | is_leaf);
        }
        let is_found = place != NO_PLACE;
        let root = sphere_nearness(ray, tree_sphere(select(0u, place, is_found)));
        let low = select(0.0, root.low, is_found);
        let high = select(0.0, root.high, is_found);
        nearest = nearer(nearest, Nearness(low, high), id);
        t_max = t_bound(ray.a * nearest.low);
    }
    return unless_stopped(nearest, at);
}
