// Where rays meet objects: the formulas of src/seen, operation by operation. The bounds are derived in src/guard.rs.

// Bounds of the t at which an object is seen. low at least BEYOND: surely nowhere. high there: perhaps nowhere.
struct Bounds {
    low: f32,
    high: f32,
}

// The nearest object so far: bounds of its t, and the least that all others may have.
struct Nearest {
    low: f32,
    high: f32,
    second: f32,
    id: u32,
}

fn nearer(nearest: Nearest, next: Bounds, id: u32) -> Nearest {
    let is_nearer = next.low < nearest.low;
    let second = min(nearest.second, next.low);
    return Nearest(
        select(nearest.low, next.low, is_nearer),
        select(nearest.high, next.high, is_nearer),
        select(second, nearest.low, is_nearer),
        select(nearest.id, id, is_nearer),
    );
}

//#if sphere_filter
struct SphereLeaf {
    center: vec3f,
    inner2: f32,
    outer2: f32,
    slack: f32,
    near_most: f32,
}

// The line's point nearest to the centre, by how much the square of its distance is below those of the two radii, half the
// chord, and the chord's ends.
struct Chord {
    s: f32,
    inner: f32,
    outer: f32,
    half_inner: f32,
    half_outer: f32,
    near: Bounds,
    far: Bounds,
}

fn chord_of(ray: Ray, leaf: SphereLeaf, l: vec3f) -> Chord {
    let s = dot3(ray.direction, l) * ray.inv_a;
    let to_center = l - ray.direction * s;
    let m = dot3(to_center, to_center);
    let inner = leaf.inner2 - m;
    let outer = leaf.outer2 - m;
    let half_inner = sqrt(max(inner, 0.0) * ray.inv_a);
    let half_outer = sqrt(max(outer, 0.0) * ray.inv_a);
    let near_high = min((s - half_inner) + leaf.slack, leaf.near_most);
    let near = Bounds((s - half_outer) - leaf.slack, near_high);
    let far = Bounds((s + half_inner) - leaf.slack, (s + half_outer) + leaf.slack);
    return Chord(s, inner, outer, half_inner, half_outer, near, far);
}

fn leaf_bounds(ray: Ray, leaf: SphereLeaf) -> Bounds {
    let chord = chord_of(ray, leaf, leaf.center - ray.origin);
    let low = select(chord.near.low, chord.far.low, chord.near.high <= 0.0);
    let high = select(chord.far.high, chord.near.high, 0.0 < chord.near.low);
    let is_missed = chord.outer < 0.0 || chord.far.high <= 0.0;
    let is_hit = 0.0 <= chord.inner && 0.0 < chord.far.low;
    return Bounds(select(low, BEYOND, is_missed), select(BEYOND, high, is_hit));
}
//#end

//#if spheres
struct SphereCertified {
    center: vec3f,
    inner2: f32,
    outer2: f32,
    slack: f32,
    near_most: f32,
    is_close: f32,
    k: f32,
    k_error: f32,
    k_width: f32,
    padding: f32,
}

//#if close
// Of a sphere so large and so close that its size hides its distance: by the roots' product, k / a.
fn close_bounds(ray: Ray, sphere: SphereCertified, leaf: SphereLeaf) -> Bounds {
    let l = leaf.center - ray.origin;
    let chord = chord_of(ray, leaf, l);
    let s = chord.s;
    let k = sphere.k - dot3(ray.origin, leaf.center + l);
    let outside = sphere.k_error < k;
    let inside = k <= -sphere.k_error;
    let sum_low = (abs(s) + chord.half_inner) - leaf.slack;
    let sum_high = (abs(s) + chord.half_outer) + leaf.slack;
    let low_k = ((abs(k) - sphere.k_error) * ray.inv_a) / sum_high * (1.0 - sphere.k_width);
    let most_k =
        ((abs(k) + sphere.k_error) * ray.inv_a) / max(sum_low, leaf.slack) * (1.0 + sphere.k_width);
    let high_k = select(BEYOND, most_k, leaf.slack < sum_low);
    // From outside both roots have the sign of s; from inside the far one alone is positive.
    let low = select(max(chord.far.low, low_k), max(chord.near.low, low_k), outside);
    let from_inside = select(chord.far.high, min(chord.far.high, high_k), s < 0.0);
    let high = select(from_inside, min(chord.near.high, high_k), outside);
    let is_known = outside || inside;
    let is_missed = outside && (chord.outer < 0.0 || s < -leaf.slack);
    let is_hit = (outside && 0.0 <= chord.inner && leaf.slack < s) || inside;
    return Bounds(
        select(select(0.0, low, is_known), BEYOND, is_missed),
        select(BEYOND, select(BEYOND, high, is_known), is_hit),
    );
}
//#end

fn sphere_bounds(ray: Ray, sphere: SphereCertified) -> Bounds {
    let leaf =
        SphereLeaf(sphere.center, sphere.inner2, sphere.outer2, sphere.slack, sphere.near_most);
    let bounds = leaf_bounds(ray, leaf);
    //#if close
    let close = close_bounds(ray, sphere, leaf);
    let is_close = sphere.is_close > 0.0;
    return Bounds(
        select(bounds.low, close.low, is_close), select(bounds.high, close.high, is_close));
    //#else
    return bounds;
    //#end
}
//#end

//#if planes
struct PlaneCertified {
    normal: vec3f,
    offset: f32,
    offset_error: f32,
    slope_error: f32,
    padding: vec2f,
}

fn plane_bounds(ray: Ray, plane: PlaneCertified) -> Bounds {
    let offset = plane.offset - dot3(plane.normal, ray.origin);
    let slope = dot3(plane.normal, ray.direction);
    let away = select(slope, -slope, offset < 0.0);
    let error = plane.slope_error * ray.a;
    let slow = away - error;
    let quick = away + error;
    let reach = abs(offset) + plane.offset_error;
    let least_slope = max(reach * (1.0 / BEYOND), TINY);
    let least = ((abs(offset) - plane.offset_error) / max(quick, least_slope)) * (1.0 - QUOTIENT);
    let most = (reach / max(slow, least_slope)) * (1.0 + QUOTIENT);
    let is_known = plane.offset_error < abs(offset);
    let is_missed = is_known && quick <= 0.0;
    let is_hit = is_known && least_slope < slow;
    let low = select(0.0, min(least, 0.5 * BEYOND), is_known);
    return Bounds(select(low, BEYOND, is_missed), select(BEYOND, most, is_hit));
}
//#end

//#if spheres
//#if tree
//#else
fn sphere_id(index: u32) -> u32 {
    return index + 1u;
}
//#end
//#end

// The nearest of the objects that are tested one after the other.
fn nearest_listed(ray: Ray) -> Nearest {
    var nearest = Nearest(BEYOND, BEYOND, BEYOND, 0u);
    //#each sphere
    nearest = nearer(nearest, sphere_bounds(ray, spheres[INDEX]), sphere_id(INDEX));
    //#end
    //#each plane
    nearest = nearer(nearest, plane_bounds(ray, planes[INDEX]), params.n_spheres + INDEX + 1u);
    //#end
    return nearest;
}

// The object, or UNDECIDED where the bounds leave it open.
fn decide(nearest: Nearest) -> u32 {
    let is_sure = nearest.high < nearest.second || BEYOND <= nearest.low;
    return select(UNDECIDED, nearest.id, is_sure);
}
