// Each ray walks through the boxes of the tree alone, as tests/src/twins/ids.rs does.

@group(0) @binding(next) var<uniform> walk: Traversal;
// Storage textures, whose texels a software device loads for all lanes at once also within a loop, without a look at levels: from
// storage buffers the walk takes some hundred times as long there. Of a box, two texels (FlatBox in src/bvh/flat.rs), and
// behind the boxes one for each sphere that is not in the tree, with its id.
@group(0) @binding(next) var boxes: texture_storage_2d<rgba32uint, read>;
// SphereLeaf, two texels each.
@group(0) @binding(next) var leaves: texture_storage_2d<rgba32uint, read>;

fn texel(index: u32) -> vec2u {
    return vec2u(index & ((1u << ROW_BITS) - 1u), index >> ROW_BITS);
}

fn sphere_id(index: u32) -> u32 {
    return textureLoad(boxes, texel(2u * walk.n_boxes + index)).x;
}

fn leaf_at(place: u32) -> SphereLeaf {
    let first = bitcast<vec4f>(textureLoad(leaves, texel(2u * place)));
    let second = bitcast<vec4f>(textureLoad(leaves, texel(2u * place + 1u)));
    return SphereLeaf(first.xyz, first.w, second.x, second.y, second.z);
}

// A walk at a box: the box that comes next, and the sphere of a leaf that is met, with its place.
struct Step {
    at: u32,
    place: u32,
    id: u32,
}

fn step_at(at: u32, slabs: Slabs, t_max: f32) -> Step {
    let low = textureLoad(boxes, texel(2u * at));
    let high = textureLoad(boxes, texel(2u * at + 1u));
    let is_leaf = (low.w & IS_LEAF) != 0u;
    let stretch = between(slabs, bitcast<vec3f>(low.xyz), bitcast<vec3f>(high.xyz));
    let is_met = is_within(stretch, t_max);
    let place = select(NO_PLACE, low.w & ~IS_LEAF, is_met & is_leaf);
    return Step(at + select(low.w, 1u, is_met | is_leaf), place, high.w);
}

fn nearest_in_tree(ray: Ray, listed: Nearest) -> Nearest {
    let slabs = slabs_of(ray, walk.beside);
    var nearest = listed;
    var step = Step(0u, NO_PLACE, 0u);
    var n_left = MOST_BOXES;
    while step.at < walk.n_boxes && n_left > 0u {
        // A lane that has found a sphere waits until the others have, and all test theirs at once.
        step.place = NO_PLACE;
        while step.at < walk.n_boxes && step.place == NO_PLACE && n_left > 0u {
            n_left -= 1u;
            step = step_at(step.at, slabs, nearest.high);
        }
        let is_found = step.place != NO_PLACE;
        let bounds = leaf_bounds(leaf_at(select(0u, step.place, is_found)), ray);
        let low = select(nearest_none().low, bounds.low, is_found);
        nearest = nearest_with(nearest, Bounds(low, bounds.high), step.id);
    }
    // Undecided: the walk stops after MOST_BOXES, and a device in software may stop it sooner.
    if step.at < walk.n_boxes {
        nearest.low = 0.0;
        nearest.second = 0.0;
    }
    return nearest;
}
