// Twin of src/kernel/relative.rs: the formulas of the kernels stable (f32) and double (f64), relative
// to the ray's origin and free of cancellation.

// From a ray's origin to a point in two parts, relative to the reference point. In f64 the second ones change nothing.
fn offset_from(ray: Ray, high: Vec3, low: Vec3) -> Vec3 {
    //#if double
    return high - ray.origin;
    //#else
    return (high - ray.origin) + (low - ray.origin_low);
    //#end
}

struct SphereRelative {
    center: Vec3,
    radius: Real,
    center_low: Vec3,
    k: Real,
}

// l = c − o
fn sphere_offset(ray: Ray, sphere: SphereRelative) -> Vec3 {
    //#if point
    return sphere.center;
    //#else
    return offset_from(ray, sphere.center, sphere.center_low);
    //#end
}

// l·l − r², from the host's f64 where all rays share their origin.
fn sphere_k(l: Vec3, sphere: SphereRelative) -> Real {
    //#if point
    return sphere.k;
    //#else
    return dot3(l, l) - sphere.radius * sphere.radius;
    //#end
}

// The numbers for a ray that starts elsewhere than all others, which have theirs from the host.
fn sphere_from(ray: Ray, sphere: SphereRelative) -> SphereRelative {
    let l = offset_from(ray, sphere.center, sphere.center_low);
    return SphereRelative(l, sphere.radius, Vec3(0.0), dot3(l, l) - sphere.radius * sphere.radius);
}

// The ray's closest approach to a centre at l = c − o.
struct Approach {
    // Offset from the closest point of the line to the centre.
    p: Vec3,
    // d·l
    b: Real,
    // r² − p·p
    delta: Real,
}

// Discriminant as r² − ‖P‖² (Hearn & Baker; Ray Tracing Gems, ch. 7, eq. 5).
fn approach(ray: Ray, l: Vec3, r: Real) -> Approach {
    let b = dot3(ray.direction, l);
    let p = l - ray.direction * (b * ray.inv_a);
    return Approach(p, b, r * r - dot3(p, p));
}

// Half the chord times ‖d‖²: √(a (r² − p·p)); negative for a miss.
fn half_root(ray: Ray, delta: Real) -> Real {
    return select(-1.0, sqrt(ray.a * delta), delta >= 0.0);
}

// Near and far root without cancellation: q and k/q (Press et al., Numerical Recipes, 5.6).
fn roots_stable(ray: Ray, b: Real, h: Real, k: Real) -> vec2<Real> {
    let q = select(b - h, b + h, b > 0.0);
    let t0 = k / q;
    let t1 = q * ray.inv_a;
    return select(vec2<Real>(t1, t0), vec2<Real>(t0, t1), b > 0.0);
}

// Smallest positive root, or 0 for none.
fn sphere_stable(ray: Ray, l: Vec3, r: Real, k: Real) -> Real {
    let closest_approach = approach(ray, l, r);
    let h = half_root(ray, closest_approach.delta);
    let roots = roots_stable(ray, closest_approach.b, h, k);
    let t = select(select(0.0, roots.y, roots.y > 0.0), roots.x, roots.x > 0.0);
    return select(0.0, t, h >= 0.0);
}

fn closer_sphere(ray: Ray, hit: Hit, sphere: SphereRelative, id: u32) -> Hit {
    let l = sphere_offset(ray, sphere);
    return closer(hit, sphere_stable(ray, l, sphere.radius, sphere_k(l, sphere)), id);
}

// At a hit, of any length: from half the chord, never from t, as o + t·d − c cancels far away.
fn sphere_normal(ray: Ray, hit: Hit, sphere: SphereRelative) -> Vec3 {
    let l = sphere_offset(ray, sphere);
    let closest_approach = approach(ray, l, sphere.radius);
    let half_chord = ray.direction * (half_root(ray, closest_approach.delta) * ray.inv_a);
    let outside = sphere_k(l, sphere) > 0.0;
    return select(half_chord, -half_chord, outside) - closest_approach.p;
}

struct PlaneRelative {
    offset: Vec3,
    n_offset: Real,
    offset_low: Vec3,
    normal: Vec3,
}

// (a − o)·n, from the host's f64 where all rays share their origin.
fn plane_n_offset(ray: Ray, plane: PlaneRelative) -> Real {
    //#if point
    return plane.n_offset;
    //#else
    return dot3(offset_from(ray, plane.offset, plane.offset_low), plane.normal);
    //#end
}

// The same as with spheres.
fn plane_from(ray: Ray, plane: PlaneRelative) -> PlaneRelative {
    let l = offset_from(ray, plane.offset, plane.offset_low);
    return PlaneRelative(l, dot3(l, plane.normal), Vec3(0.0), plane.normal);
}

// t = ((a − o)·n) / (d·n). Positive t, or 0 for none.
fn plane_stable(d: Vec3, n_offset: Real, n: Vec3) -> Real {
    let t = n_offset / dot3(d, n);
    return select(0.0, t, t > 0.0);
}

fn closer_plane(ray: Ray, hit: Hit, plane: PlaneRelative, id: u32) -> Hit {
    return closer(hit, plane_stable(ray.direction, plane_n_offset(ray, plane), plane.normal), id);
}

fn plane_normal(ray: Ray, hit: Hit, plane: PlaneRelative) -> Vec3 {
    return plane.normal;
}

//#if double
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
//#end
