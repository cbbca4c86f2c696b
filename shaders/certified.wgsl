// Twin of src/kernel/certified.rs. The bounds are derived in src/guard.rs.

// Where a root lies. low = +∞: a certain miss. high = +∞: not certain that there is a root.
struct Interval {
    low: f32,
    high: f32,
}

// The nearest candidate and the lower end of the second nearest.
struct Nearest {
    low: f32,
    high: f32,
    second_low: f32,
    id: u32,
}

fn nearer(nearest: Nearest, root: Interval, id: u32) -> Nearest {
    let is_nearer = root.low < nearest.low;
    return Nearest(
        select(nearest.low, root.low, is_nearer),
        select(nearest.high, root.high, is_nearer),
        min(nearest.second_low, max(nearest.low, root.low)),
        select(nearest.id, id, is_nearer),
    );
}

//#if spheres
struct SphereCertified {
    center: vec3f,
    inner2: f32,
    center_low: vec3f,
    outer2: f32,
    k: f32,
    k_error: f32,
    slack: f32,
    padding: f32,
}

// The visible root of the sphere at l = c − o, with k = l·l − r² known up to k_error.
fn sphere_interval(
    ray: Ray,
    l: vec3f,
    k: f32,
    k_error: f32,
    inner2: f32,
    outer2: f32,
    slack: f32,
) -> Interval {
    let s = dot3(ray.direction, l) * ray.inv_a;
    let p = l - ray.direction * s;
    let m = dot3(p, p);
    let outside = k > k_error;
    let inside = k < -k_error;
    let u = abs(s);
    let u_low = (u + sqrt(max(inner2 - m, 0.0) * ray.inv_a)) - slack;
    let u_high = (u + sqrt(max(outer2 - m, 0.0) * ray.inv_a)) + slack;
    let k_low = (abs(k) - k_error) * ray.inv_a;
    let k_high = (abs(k) + k_error) * ray.inv_a;
    let is_u = !outside && s > 0.0;
    let low = select(k_low / u_high, u_low, is_u) * NARROWER;
    let high = select(k_high / u_low, u_high, is_u) * WIDER;
    let possible = m <= outer2 && (inside || s >= -slack);
    let certain = m <= inner2 && (inside || s > slack) && u_low > 0.0;
    //#if pixels
    return Interval(
        select(params.infinity, low, possible),
        select(params.infinity, high, certain),
    );
    //#else
    let known = outside || inside;
    return Interval(
        select(select(params.infinity, 0.0, m <= outer2), select(params.infinity, low, possible), known),
        select(params.infinity, high, certain && known),
    );
    //#end
}

fn nearer_sphere(ray: Ray, nearest: Nearest, sphere: SphereCertified, id: u32) -> Nearest {
    //#if pixels
    let l = sphere.center;
    let k = sphere.k;
    let k_error = 0.0;
    //#else
    let l = (sphere.center - ray.origin) + (sphere.center_low - ray.origin_low);
    let k = dot3(l, l) - sphere.k;
    let k_error = sphere.k_error;
    //#end
    let root = sphere_interval(ray, l, k, k_error, sphere.inner2, sphere.outer2, sphere.slack);
    return nearer(nearest, root, id);
}
//#end

//#if planes
struct PlaneCertified {
    offset: vec3f,
    n_offset: f32,
    offset_low: vec3f,
    n_offset_error: f32,
    normal: vec3f,
    direction_error: f32,
}

// t = n_offset / (d·n), with n_offset known up to n_offset_error.
fn plane_interval(
    ray: Ray,
    n_offset: f32,
    n_offset_error: f32,
    normal: vec3f,
    direction_error: f32,
) -> Interval {
    let numerator = abs(n_offset);
    let slope = dot3(ray.direction, normal);
    let denominator = select(slope, -slope, n_offset < 0.0);
    let error = direction_error * sqrt(ray.a);
    let low = (numerator - n_offset_error) / (denominator + error) * NARROWER;
    let high = (numerator + n_offset_error) / (denominator - error) * WIDER;
    let known = numerator > n_offset_error;
    let possible = denominator > -error;
    let certain = known && denominator > error;
    //#if pixels
    return Interval(
        select(params.infinity, low, known && possible),
        select(params.infinity, high, certain),
    );
    //#else
    return Interval(
        select(0.0, select(params.infinity, low, possible), known),
        select(params.infinity, high, certain),
    );
    //#end
}

fn nearer_plane(ray: Ray, nearest: Nearest, plane: PlaneCertified, id: u32) -> Nearest {
    //#if pixels
    let n_offset = plane.n_offset;
    let n_offset_error = 0.0;
    //#else
    let l = (plane.offset - ray.origin) + (plane.offset_low - ray.origin_low);
    let n_offset = dot3(l, plane.normal);
    let n_offset_error = plane.n_offset_error;
    //#end
    let root =
        plane_interval(ray, n_offset, n_offset_error, plane.normal, plane.direction_error);
    return nearer(nearest, root, id);
}
//#end

// The object of a ray, or UNDECIDED.
fn propose(ray: Ray) -> u32 {
    var nearest =
        Nearest(params.infinity, params.infinity, params.infinity, 0u);
    //#each sphere
    nearest = nearer_sphere(ray, nearest, spheres[INDEX], INDEX + 1u);
    //#end
    //#each plane
    nearest = nearer_plane(ray, nearest, planes[INDEX], params.n_spheres + INDEX + 1u);
    //#end
    let decided = nearest.id == 0u || nearest.high < nearest.second_low;
    return select(UNDECIDED, nearest.id, decided);
}
