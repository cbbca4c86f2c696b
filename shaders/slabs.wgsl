// Twin of src/tree/slabs.rs, which derives the bounds.

//#if tree
struct Slab {
    near_origin: Real,
    far_origin: Real,
    near_inverse: Real,
    far_inverse: Real,
    goes_down: bool,
    is_flat: bool,
}

struct Slabs {
    x: Slab,
    y: Slab,
    z: Slab,
}

struct Stretch {
    enter: Real,
    leave: Real,
}

fn slab_of(origin: Real, direction: Real, slack: Real) -> Slab {
    let is_flat = abs(direction) < FLAT;
    let way = select(direction, 1.0, is_flat);
    let inverse = 1.0 / way;
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

fn slabs_of(ray: Ray) -> Slabs {
    let origin = ray.origin;
    let slack = max(max(abs(origin.x), abs(origin.y)), abs(origin.z)) * ASIDE_ROOM + LEAST_SLACK;
    return Slabs(
        slab_of(origin.x, ray.direction.x, slack),
        slab_of(origin.y, ray.direction.y, slack),
        slab_of(origin.z, ray.direction.z, slack),
    );
}

fn stretch(slab: Slab, low: Real, high: Real) -> Stretch {
    let near_side = select(low, high, slab.goes_down);
    let far_side = select(high, low, slab.goes_down);
    let near = (near_side - slab.near_origin) * slab.near_inverse;
    let far = (far_side - slab.far_origin) * slab.far_inverse;
    let is_beside = near > 0.0 || far < 0.0;
    let never = select(0.0, LARGEST, is_beside);
    return Stretch(select(near, never, slab.is_flat), select(far, LARGEST, slab.is_flat));
}

fn meets(slabs: Slabs, low: Vec3, high: Vec3, t_max: Real) -> bool {
    let x = stretch(slabs.x, low.x, high.x);
    let y = stretch(slabs.y, low.y, high.y);
    let z = stretch(slabs.z, low.z, high.z);
    let enter = max(max(max(x.enter, y.enter), z.enter), 0.0);
    return enter <= x.leave && enter <= y.leave && enter <= z.leave && enter <= t_max;
}
//#end
