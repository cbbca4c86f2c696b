// The objects that a ray looks at one after the other. Their formulas are printed from src/shape: printed/shape.wgsl.

fn sphere_bounds(sphere: SphereRecord, ray: Ray) -> Bounds {
    let bounds = leaf_bounds(sphere_leaf(sphere), ray);
    //#if close
    let close = sphere_bounds_close(sphere, ray);
    let is_close = sphere.is_close > 0.0;
    return Bounds(
        select(bounds.low, close.low, is_close), select(bounds.high, close.high, is_close));
    //#else
    return bounds;
    //#end
}

//#each indexed shape
fn shape_id(index: u32) -> u32 {
    return first_shape() + index;
}
//#end

fn nearest_listed(ray: Ray) -> Nearest {
    var nearest = nearest_none();
    //#each listed shape
    for (var i = 0u; i < N_SHAPES; i++) {
        nearest = nearest_with(nearest, shape_bounds(shapes[i], ray), shape_id(i));
    }
    //#end
    return nearest;
}

fn id_of(ray: Ray) -> u32 {
    //#if tree
    return decide(nearest_in_tree(ray, nearest_listed(ray)));
    //#else
    return decide(nearest_listed(ray));
    //#end
}
