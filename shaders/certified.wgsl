// The objects that a ray looks at one after the other. Their formulas are printed from src/seen: printed/seen.wgsl.

//#if spheres
//#if tree
//#else
fn sphere_id(index: u32) -> u32 {
    return index + 1u;
}
//#end

fn sphere_bounds(sphere: SphereSeen, ray: Ray) -> Bounds {
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
//#end

fn nearest_listed(ray: Ray) -> Nearest {
    var nearest = nearest_none();
    //#if spheres
    for (var i = 0u; i < N_SPHERES; i++) {
        nearest = nearest_with(nearest, sphere_bounds(spheres[i], ray), sphere_id(i));
    }
    //#end
    //#if planes
    for (var i = 0u; i < N_PLANES; i++) {
        nearest = nearest_with(nearest, plane_bounds(planes[i], ray), params.n_spheres + i + 1u);
    }
    //#end
    return nearest;
}
