// Twin of src/kernel/stable/twin.rs: the best plain-f32 kernel, camera-relative.

//#if spheres
struct SphereStable {
    center: vec3f,
    radius: f32,
    center_low: vec3f,
    k: f32,
}

fn sphere_offset(ray: Ray, sphere: SphereStable) -> vec3f {
    //#if point
    return sphere.center;
    //#else
    return (sphere.center - ray.origin) + (sphere.center_low - ray.origin_low);
    //#end
}

// l·l − r², from the host's f64 where all rays share their origin.
fn sphere_k(l: vec3f, sphere: SphereStable) -> f32 {
    //#if point
    return sphere.k;
    //#else
    return dot3(l, l) - sphere.radius * sphere.radius;
    //#end
}

//#if moved
// The numbers for a ray that starts elsewhere than all others, which have theirs from the host.
fn sphere_from(ray: Ray, sphere: SphereStable) -> SphereStable {
    let l = (sphere.center - ray.origin) + (sphere.center_low - ray.origin_low);
    return SphereStable(l, sphere.radius, vec3f(0.0), dot3(l, l) - sphere.radius * sphere.radius);
}
//#end
//#end

//#if planes
struct PlaneStable {
    offset: vec3f,
    n_offset: f32,
    offset_low: vec3f,
    normal: vec3f,
}

// (a − o)·n, from the host's f64 where all rays share their origin.
fn plane_n_offset(ray: Ray, plane: PlaneStable) -> f32 {
    //#if point
    return plane.n_offset;
    //#else
    return dot3((plane.offset - ray.origin) + (plane.offset_low - ray.origin_low), plane.normal);
    //#end
}

//#if moved
// The same as with spheres.
fn plane_from(ray: Ray, plane: PlaneStable) -> PlaneStable {
    let l = (plane.offset - ray.origin) + (plane.offset_low - ray.origin_low);
    return PlaneStable(l, dot3(l, plane.normal), vec3f(0.0), plane.normal);
}
//#end
//#end
