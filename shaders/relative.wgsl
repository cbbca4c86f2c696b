// The numbers of the kernels stable (f32) and double (f64), relative to where rays start, as in src/kernel/relative.rs. The
// formulas are printed from there: printed/relative.wgsl.

struct SphereRelative {
    center: Vec3,
    radius: Real,
    center_low: Vec3,
    k: Real,
}

struct PlaneRelative {
    offset: Vec3,
    n_offset: Real,
    offset_low: Vec3,
    normal: Vec3,
}

// From a ray's origin to a point in two parts, relative to the reference point. In f64 the second ones change nothing.
fn offset_from(ray: Ray, high: Vec3, low: Vec3) -> Vec3 {
    //#if double
    return high - ray.origin;
    //#else
    return (high - ray.origin) + (low - ray.origin_low);
    //#end
}

// The numbers for a ray that starts elsewhere than at the reference point, for which the host has made them in f64.
fn sphere_from(ray: Ray, sphere: SphereRelative) -> SphereRelative {
    let l = offset_from(ray, sphere.center, sphere.center_low);
    return SphereRelative(l, sphere.radius, Vec3(0.0), dot3(l, l) - sphere.radius * sphere.radius);
}

// The numbers of a plane, as those of a sphere.
fn plane_from(ray: Ray, plane: PlaneRelative) -> PlaneRelative {
    let l = offset_from(ray, plane.offset, plane.offset_low);
    return PlaneRelative(l, dot3(l, plane.normal), Vec3(0.0), plane.normal);
}

fn closer_sphere(ray: Ray, hit: Hit, sphere: SphereRelative, id: u32) -> Hit {
    return closer(hit, sphere_stable(ray, sphere.center, sphere.radius, sphere.k), id);
}

// At a hit, of any length.
fn sphere_normal(ray: Ray, hit: Hit, sphere: SphereRelative) -> Vec3 {
    return from_center(ray, sphere.center, sphere.radius, sphere.k);
}

fn closer_plane(ray: Ray, hit: Hit, plane: PlaneRelative, id: u32) -> Hit {
    return closer(hit, plane_stable(ray.direction, plane.n_offset, plane.normal), id);
}

fn plane_normal(ray: Ray, hit: Hit, plane: PlaneRelative) -> Vec3 {
    return plane.normal;
}
