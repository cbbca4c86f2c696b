// Twin of src/kernel/certified/filter.rs. The bounds are derived in src/guard.rs.

// Bounds of a visible root's nearness 1 / (a t): unlike t it needs no division.
// high ≤ 0: a certain miss. low ≤ 0: not certain that there is a root.
struct Nearness {
    low: Real,
    high: Real,
}

// The nearest candidate, and the upper bound of the second nearest.
struct Nearest {
    low: Real,
    high: Real,
    second_high: Real,
    id: u32,
}

fn nearer(nearest: Nearest, root: Nearness, id: u32) -> Nearest {
    let is_nearer = root.high > nearest.high;
    let farther = select(root.high, nearest.high, is_nearer);
    return Nearest(
        select(nearest.low, root.low, is_nearer),
        select(nearest.high, root.high, is_nearer),
        select(nearest.second_high, farther, farther > nearest.second_high),
        select(nearest.id, id, is_nearer),
    );
}

//#if far
// As from outside, where the slack is a small part of s + h for every sphere and is held in q. The
// lower bound still lacks the factor FAR_NARROWER.
fn far_nearness(ray: Ray, l: Vec3, inner2: Real, outer2: Real, q: Real) -> Nearness {
    let s = dot3(ray.direction, l) * ray.inv_a;
    let p = l - ray.direction * s;
    let m = dot3(p, p);
    let inner = inner2 - m;
    let outer = outer2 - m;
    let low = (s + sqrt(abs(inner) * ray.inv_a)) * q;
    let high = (s + sqrt(abs(outer) * ray.inv_a)) * q;
    return Nearness(select(0.0, low, inner >= 0.0), select(0.0, high, outer >= 0.0));
}
//#end

//#if parallel
// Seen along one direction: t = s − h, or s + h where that is behind. Whatever is not known to be
// the visible root is open.
fn parallel_nearness(ray: Ray, l: Vec3, inner2: Real, outer2: Real, slack: Real) -> Nearness {
    let s = dot3(ray.direction, l) * ray.inv_a;
    let p = l - ray.direction * s;
    let m = dot3(p, p);
    let inner = inner2 - m;
    let outer = outer2 - m;
    let h_inner = sqrt(max(inner, 0.0) * ray.inv_a);
    let h_outer = sqrt(max(outer, 0.0) * ray.inv_a);
    let near_low = (s - h_outer) - slack;
    let near_high = (s - h_inner) + slack;
    let far_low = (s + h_inner) - slack;
    let far_high = (s + h_outer) + slack;
    let is_near = near_low > SMALL;
    let is_far = near_high <= 0.0 && far_low > SMALL;
    let t_low = select(far_low, near_low, is_near);
    let t_high = select(far_high, near_high, is_near);
    let is_missed = outer < 0.0 || far_high <= 0.0;
    let is_hit = inner >= 0.0 && far_low > SMALL;
    let low = ray.inv_a / max(t_high, SMALL) * NARROWER;
    let high = ray.inv_a / max(t_low, SMALL) * WIDER;
    let high_or_open = select(LARGEST, high, is_near || is_far);
    return Nearness(select(0.0, low, is_hit), select(high_or_open, 0.0, is_missed));
}
//#end

//#if sphere_filter
struct SphereCertified {
    center: Vec3,
    inner2: Real,
    center_low: Vec3,
    outer2: Real,
    slack: Real,
    q_low: Real,
    q_high_or_r2: Real,
    k_error: Real,
}

//#if parallel
fn sphere_nearness(ray: Ray, sphere: SphereCertified) -> Nearness {
    return parallel_nearness(
        ray, sphere.center - ray.origin, sphere.inner2, sphere.outer2, sphere.slack);
}
//#else
// The sphere at l = c − o, whose bounds are the guard's, seen from outside: 1 / (a t) = (s + h) q with
// q = 1 / k.
fn outside_nearness(ray: Ray, l: Vec3, guard: SphereCertified, q: Nearness) -> Nearness {
    let s = dot3(ray.direction, l) * ray.inv_a;
    let p = l - ray.direction * s;
    let m = dot3(p, p);
    let inner = guard.inner2 - m;
    let outer = guard.outer2 - m;
    let low = ((s - guard.slack) + sqrt(max(inner, 0.0) * ray.inv_a)) * q.low;
    let high = ((s + guard.slack) + sqrt(max(outer, 0.0) * ray.inv_a)) * q.high;
    return Nearness(select(0.0, low, inner >= 0.0), select(0.0, high, outer >= 0.0));
}

// Seen from inside: t = s + h where s > 0, and 1 / (a t) = (h − s) / |k| elsewhere. On the surface
// q is 0 and the roots are 0 and 2 s.
fn inside_nearness(ray: Ray, l: Vec3, guard: SphereCertified, q: Nearness) -> Nearness {
    let s = dot3(ray.direction, l) * ray.inv_a;
    let p = l - ray.direction * s;
    let m = dot3(p, p);
    let u_low = (abs(s) + sqrt(max(guard.inner2 - m, 0.0) * ray.inv_a)) - guard.slack;
    let u_high = (abs(s) + sqrt(max(guard.outer2 - m, 0.0) * ray.inv_a)) + guard.slack;
    let is_apart = u_low > 0.0;
    let ahead = Nearness(
        ray.inv_a / u_high * NARROWER,
        select(LARGEST, ray.inv_a / select(1.0, u_low, is_apart) * WIDER, is_apart),
    );
    let low = select(u_low * q.low, ahead.low, s > 0.0);
    let high = select(u_high * q.high, ahead.high, s > 0.0);
    let open = q.high == 0.0 && abs(s) <= guard.slack;
    return Nearness(select(low, 0.0, open), select(high, LARGEST, open));
}

fn sphere_nearness(ray: Ray, sphere: SphereCertified) -> Nearness {
    //#if point
    let l = sphere.center;
    let q = Nearness(sphere.q_low, sphere.q_high_or_r2);
    let is_outside = q.low > 0.0;
    //#else
    let l = (sphere.center - ray.origin) + (sphere.center_low - ray.origin_low);
    let k = dot3(l, l) - sphere.q_high_or_r2;
    let is_outside = k > 0.0;
    let is_known = abs(k) > sphere.k_error;
    let q = Nearness(
        NARROWER / (abs(k) + sphere.k_error),
        WIDER / select(1.0, abs(k) - sphere.k_error, is_known),
    );
    //#end
    let outside = outside_nearness(ray, l, sphere, q);
    let inside = inside_nearness(ray, l, sphere, Nearness(abs(q.low), abs(q.high)));
    let low = select(inside.low, outside.low, is_outside);
    let high = select(inside.high, outside.high, is_outside);
    //#if free
    return Nearness(select(0.0, low, is_known), select(LARGEST, high, is_known));
    //#else
    return Nearness(low, high);
    //#end
}
//#end
//#end

//#if planes
struct PlaneCertified {
    offset: Vec3,
    q_low: Real,
    offset_low: Vec3,
    q_high: Real,
    normal: Vec3,
    direction_error: Real,
    n_offset_error: Real,
}

// 1 / (a t) = (d·n) q / a with q = 1 / ((a − o)·n).
fn plane_nearness(ray: Ray, plane: PlaneCertified) -> Nearness {
    let error = plane.direction_error * sqrt(ray.a);
    let slope = dot3(ray.direction, plane.normal);
    //#if point
    // The normal points away from the eye.
    let q = Nearness(plane.q_low, plane.q_high);
    return Nearness((slope - error) * ray.inv_a * q.low, (slope + error) * ray.inv_a * q.high);
    //#else
    let l = (plane.offset - ray.origin) + (plane.offset_low - ray.origin_low);
    let n_offset = dot3(l, plane.normal);
    let away = select(slope, -slope, n_offset < 0.0);
    let is_known = abs(n_offset) > plane.n_offset_error;
    let q = Nearness(
        NARROWER / (abs(n_offset) + plane.n_offset_error),
        WIDER / select(1.0, abs(n_offset) - plane.n_offset_error, is_known),
    );
    let low = (away - error) * ray.inv_a * q.low;
    let high = (away + error) * ray.inv_a * q.high;
    return Nearness(select(0.0, low, is_known), select(LARGEST, high, is_known));
    //#end
}
//#end

//#if spheres
//#if hierarchy
//#else
//#if tree
//#else
fn sphere_id(index: u32) -> u32 {
    return index + 1u;
}
//#end
//#end
//#end

// The nearest of the objects that are tested one after the other.
fn nearest_listed(ray: Ray) -> Nearest {
    var nearest = Nearest(0.0, 0.0, 0.0, 0u);
    //#each sphere
    nearest = nearer(nearest, sphere_nearness(ray, spheres[INDEX]), sphere_id(INDEX));
    //#end
    //#each plane
    nearest = nearer(nearest, plane_nearness(ray, planes[INDEX]), params.n_spheres + INDEX + 1u);
    //#end
    return nearest;
}

// The object, or UNDECIDED where the bounds leave it open.
fn decide(nearest: Nearest) -> u32 {
    let is_decided = nearest.id == 0u || nearest.low > nearest.second_high;
    return select(UNDECIDED, nearest.id, is_decided);
}
