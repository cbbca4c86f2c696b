// Twin of src/kernel/certified.rs. The bounds are derived in src/guard.rs.

// The nearest candidate and the lower end of the second nearest.
struct Nearest {
    low: f32,
    high: f32,
    second_low: f32,
    id: u32,
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

// What a ray's passage by a sphere says about the visible root.
struct Passage {
    // Parameter of the point of the ray's line that is closest to the centre.
    s: f32,
    k: f32,
    k_error: f32,
    slack: f32,
    // Bounds of r² − p², the one for the lower and the one for the upper end of t.
    low_chord2: f32,
    high_chord2: f32,
    possible: bool,
    certain: bool,
}

// The passage by the sphere at l = c − o, with k = l·l − r² known up to k_error.
fn pass_by(ray: Ray, l: vec3f, k: f32, k_error: f32, sphere: SphereCertified) -> Passage {
    let s = dot3(ray.direction, l) * ray.inv_a;
    let p = l - ray.direction * s;
    let m = dot3(p, p);
    let inner = sphere.inner2 - m;
    let outer = sphere.outer2 - m;
    let inside = k < -k_error;
    let is_u = root_is_u(s, k, k_error);
    return Passage(
        s,
        k,
        k_error,
        sphere.slack,
        select(outer, max(inner, 0.0), is_u),
        select(inner, outer, is_u),
        outer >= 0.0 && (inside || s >= -sphere.slack),
        inner >= 0.0 && (inside || s > sphere.slack),
    );
}

// Whether the visible root is u = |s| + h, rather than |k| / (a u).
fn root_is_u(s: f32, k: f32, k_error: f32) -> bool {
    return k <= k_error && s > 0.0;
}

//#if list
// Whether it is certain on which side of the surface the ray starts.
fn side_is_known(passage: Passage) -> bool {
    return abs(passage.k) > passage.k_error;
}
//#end

fn root_low(ray: Ray, passage: Passage) -> f32 {
    let u = abs(passage.s) + sqrt(passage.low_chord2 * ray.inv_a);
    let k = (abs(passage.k) - passage.k_error) * ray.inv_a;
    let is_u = root_is_u(passage.s, passage.k, passage.k_error);
    let low = select(k / (u + passage.slack), u - passage.slack, is_u) * NARROWER;
    //#if pixels
    return select(params.infinity, low, passage.possible);
    //#else
    let known = side_is_known(passage);
    let any = passage.possible || (!known && passage.low_chord2 >= 0.0);
    return select(params.infinity, select(0.0, low, known), any);
    //#end
}

fn root_high(ray: Ray, passage: Passage) -> f32 {
    let u = abs(passage.s) + sqrt(max(passage.high_chord2, 0.0) * ray.inv_a);
    let k = (abs(passage.k) + passage.k_error) * ray.inv_a;
    let is_u = root_is_u(passage.s, passage.k, passage.k_error);
    let u_low = u - passage.slack;
    let high = select(k / u_low, u + passage.slack, is_u) * WIDER;
    //#if pixels
    let certain = passage.certain && (is_u || u_low > 0.0);
    //#else
    let certain = passage.certain && (is_u || u_low > 0.0) && side_is_known(passage);
    //#end
    return select(params.infinity, high, certain);
}

// The nearest sphere so far. The upper end of its root waits until the nearest is known.
struct NearestSphere {
    passage: Passage,
    low: f32,
    second_low: f32,
    id: u32,
}

fn nearer_sphere(ray: Ray, nearest: NearestSphere, sphere: SphereCertified, id: u32) -> NearestSphere {
    //#if pixels
    let passage = pass_by(ray, sphere.center, sphere.k, 0.0, sphere);
    //#else
    let l = (sphere.center - ray.origin) + (sphere.center_low - ray.origin_low);
    let passage = pass_by(ray, l, dot3(l, l) - sphere.k, sphere.k_error, sphere);
    //#end
    let low = root_low(ray, passage);
    let is_nearer = low < nearest.low;
    let farther = select(low, nearest.low, is_nearer);
    let known = nearest.passage;
    return NearestSphere(
        Passage(
            select(known.s, passage.s, is_nearer),
            select(known.k, passage.k, is_nearer),
            select(known.k_error, passage.k_error, is_nearer),
            select(known.slack, passage.slack, is_nearer),
            0.0,
            select(known.high_chord2, passage.high_chord2, is_nearer),
            false,
            select(known.certain, passage.certain, is_nearer),
        ),
        select(nearest.low, low, is_nearer),
        select(nearest.second_low, farther, farther < nearest.second_low),
        select(nearest.id, id, is_nearer),
    );
}
//#end

//#if planes
// Where a root lies. low = +∞: a certain miss. high = +∞: not certain that there is a root.
struct Interval {
    low: f32,
    high: f32,
}

struct PlaneCertified {
    offset: vec3f,
    n_offset: f32,
    offset_low: vec3f,
    n_offset_error: f32,
    normal: vec3f,
    direction_error: f32,
}

fn nearer(nearest: Nearest, root: Interval, id: u32) -> Nearest {
    let is_nearer = root.low < nearest.low;
    let farther = select(root.low, nearest.low, is_nearer);
    return Nearest(
        select(nearest.low, root.low, is_nearer),
        select(nearest.high, root.high, is_nearer),
        select(nearest.second_low, farther, farther < nearest.second_low),
        select(nearest.id, id, is_nearer),
    );
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
    let none = params.infinity;
    var nearest = Nearest(none, none, none, 0u);
    //#if spheres
    let no_passage = Passage(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, false, false);
    var sphere = NearestSphere(no_passage, none, none, 0u);
    //#each sphere
    sphere = nearer_sphere(ray, sphere, spheres[INDEX], INDEX + 1u);
    //#end
    nearest = Nearest(sphere.low, root_high(ray, sphere.passage), sphere.second_low, sphere.id);
    //#end
    //#each plane
    nearest = nearer_plane(ray, nearest, planes[INDEX], params.n_spheres + INDEX + 1u);
    //#end
    let decided = nearest.id == 0u || nearest.high < nearest.second_low;
    return select(UNDECIDED, nearest.id, decided);
}
