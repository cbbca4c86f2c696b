// Twin of src/kernel/double/twin.rs: the formulas of relative.wgsl in f64 from end to end.

//#if spheres
struct SphereDouble {
    center: vec3<f64>,
    radius: f64,
    k: f64,
}

fn sphere_offset(ray: Ray, sphere: SphereDouble) -> vec3<f64> {
    //#if point
    return sphere.center;
    //#else
    return sphere.center - ray.origin;
    //#end
}

// l·l − r², from the host where all rays share their origin.
fn sphere_k(l: vec3<f64>, sphere: SphereDouble) -> f64 {
    //#if point
    return sphere.k;
    //#else
    return dot3(l, l) - sphere.radius * sphere.radius;
    //#end
}

//#if moved
// The numbers for a ray that starts elsewhere than all others, which have theirs from the host.
fn sphere_from(ray: Ray, sphere: SphereDouble) -> SphereDouble {
    let l = sphere.center - ray.origin;
    return SphereDouble(l, sphere.radius, dot3(l, l) - sphere.radius * sphere.radius);
}
//#end
//#end

//#if planes
struct PlaneDouble {
    offset: vec3<f64>,
    n_offset: f64,
    normal: vec3<f64>,
}

// (a − o)·n, from the host where all rays share their origin.
fn plane_n_offset(ray: Ray, plane: PlaneDouble) -> f64 {
    //#if point
    return plane.n_offset;
    //#else
    return dot3(plane.offset - ray.origin, plane.normal);
    //#end
}

//#if moved
// The same as with spheres.
fn plane_from(ray: Ray, plane: PlaneDouble) -> PlaneDouble {
    let l = plane.offset - ray.origin;
    return PlaneDouble(l, dot3(l, plane.normal), plane.normal);
}
//#end
//#end

struct HitF32 {
    t: f32,
    id: u32,
}

// The hit as its caller sees it, in f32. What f32 can't hold is a miss.
fn narrow(hit: Hit) -> HitF32 {
    let infinity = f32(params.infinity);
    let t = f32(hit.t);
    let is_held = t < infinity;
    return HitF32(select(infinity, t, is_held), select(0u, hit.id, is_held));
}
