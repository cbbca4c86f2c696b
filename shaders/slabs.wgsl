// Twin of src/gpu/slabs.rs, which derives the bounds.

//#if tree
struct Slab {
    near_origin: f32,
    far_origin: f32,
    near_inverse: f32,
    far_inverse: f32,
    goes_down: bool,
    is_flat: bool,
}

struct Slabs {
    x: Slab,
    y: Slab,
    z: Slab,
}

struct Stretch {
    enter: f32,
    leave: f32,
}

fn slab_of(origin: f32, direction: f32, slack: f32) -> Slab {
    let is_flat = abs(direction) < FLAT;
    let way = select(direction, 1.0f, is_flat);
    let inverse = 1.0f / way;
    let goes_down = way < 0.0;
    let aside = select(slack, -slack, goes_down);
    return Slab(
        origin + aside,
        origin - aside,
        inverse * NEARER,
        inverse * FARTHER,
        goes_down,
        is_flat,
    );
}

fn slabs_of(origin: vec3f, direction: vec3f, beside: f32) -> Slabs {
    let slack = max(max(abs(origin.x), abs(origin.y)), abs(origin.z)) * ASIDE_ROOM + beside;
    return Slabs(
        slab_of(origin.x, direction.x, slack),
        slab_of(origin.y, direction.y, slack),
        slab_of(origin.z, direction.z, slack),
    );
}

fn stretch(slab: Slab, low: f32, high: f32) -> Stretch {
    let near_side = select(low, high, slab.goes_down);
    let far_side = select(high, low, slab.goes_down);
    let near = (near_side - slab.near_origin) * slab.near_inverse;
    let far = (far_side - slab.far_origin) * slab.far_inverse;
    let is_beside = near > 0.0 || far < 0.0;
    let never = select(0.0, LARGEST_F32, is_beside);
    return Stretch(select(near, never, slab.is_flat), select(far, LARGEST_F32, slab.is_flat));
}

fn meets(slabs: Slabs, low: vec3f, high: vec3f, t_max: f32) -> bool {
    let x = stretch(slabs.x, low.x, high.x);
    let y = stretch(slabs.y, low.y, high.y);
    let z = stretch(slabs.z, low.z, high.z);
    let enter = max(max(max(x.enter, y.enter), z.enter), 0.0);
    return enter <= x.leave && enter <= y.leave && enter <= z.leave && enter <= t_max;
}
//#end
