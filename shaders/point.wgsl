// Twin of src/gpu/before/point.rs, where the bounds are derived.

//#if of_scene
// Member order is checked against src/gpu/layout.rs by a test.
struct SeenSphere {
    // Of its centre in the picture, as of twice a pixel's offset.
    place: vec2f,
    place_low: vec2f,
    // 0 where its place is not used.
    depth: f32,
    error: f32,
    inverse_radius: f32,
    // 1 where its near side is seen, −1 from inside, 0 where neither is known.
    side: f32,
}

// From its centre's place in the picture to the pixel (i, j), at distance 1.
fn sphere_aside(sphere: SeenSphere, i: Real, j: Real) -> Vec3 {
    let across = (i - sphere.place.x) - sphere.place_low.x;
    let up = (j - sphere.place.y) - sphere.place_low.y;
    return params.right_step * across + params.true_up_step * up;
}

// From the ray to a place at this offset from its origin, across the ray.
fn across_ray(ray: Ray, l: Vec3) -> Vec3 {
    return l - ray.direction * (dot3(ray.direction, l) * ray.inv_a);
}

fn sphere_point(ray: Ray, aside: Vec3, sphere: SeenSphere, narrow: NarrowSphere) -> Point {
    let r = narrow.radius;
    let l = select(narrow.center, -aside * sphere.depth, sphere.depth > 0.0);
    let p = across_ray(ray, l);
    let m = dot3(p, p);
    let far = sqrt(dot3(l, l));
    let foot_error = POINT_FOOT * far + sphere.error;
    let across = POINT_ACROSS * far + sphere.error;
    let r2 = r * r;
    let half2 = r2 - m;
    let half2_error = 2.0 * (sqrt(m) * across + foot_error * foot_error) + POINT_SQUARE * r2;
    let is_known = (half2 > 4.0 * half2_error) & (sphere.side != 0.0);
    let known2 = select(1.0, half2, is_known);
    let chord = ray.direction * (sqrt(known2 * ray.inv_a) * sphere.side);
    let out = -p - chord;
    let off = foot_error + POINT_HALF * half2_error / sqrt(known2) + POINT_CHORD * r;
    let at = narrow.center + (narrow.center_low + out);
    let error = ROOM * (off + UNIT * (r + sqrt(dot3(at, at))));
    let normal = out * (sphere.inverse_radius * sphere.side);
    let normal_error = ROOM * (off * sphere.inverse_radius + POINT_NORMAL);
    return Point(at, error, normal, normal_error, is_known, sphere.side < 0.0);
}
//#end

//#if planes
// Member order is checked against src/gpu/layout.rs by a test.
struct SeenPlane {
    // The unit normal times the view axis, and times the steps to the right and up.
    slope: vec3f,
    // The unit normal times the way to the plane.
    offset: f32,
    unit: vec3f,
    error: f32,
}

fn plane_point(ray: Ray, plane: SeenPlane, i: Real, j: Real) -> Point {
    let across = plane.slope.y * i;
    let up = plane.slope.z * j;
    let length = sqrt(ray.a);
    //#if point
    let slope = (plane.slope.x + across) + up;
    let offset = plane.offset;
    let of_slope = (abs(plane.slope.x) + abs(across)) + abs(up);
    let of_offset = abs(plane.offset);
    //#else
    let slope = plane.slope.x;
    let offset = (plane.offset - across) - up;
    let of_slope = abs(plane.slope.x);
    let of_offset = (abs(plane.offset) + abs(across)) + abs(up);
    //#end
    let slope_error = POINT_SUM * of_slope + POINT_SLOPE * length;
    let offset_error = POINT_SUM * of_offset + plane.error;
    let is_apart = (abs(slope) > POINT_APART * slope_error)
        & (abs(offset) > POINT_APART * offset_error) & (abs(offset) > NEGLIGIBLE);
    let by_slope = 1.0 / select(1.0, slope, is_apart);
    let by_offset = 1.0 / select(1.0, offset, is_apart);
    let t = select(0.0, offset * by_slope, is_apart);
    let is_known = (t > 0.0) & (t * length < NARROW_REACH);
    let reach = select(0.0, t, is_known) * length;
    let relative = slope_error * abs(by_slope) + offset_error * abs(by_offset);
    let start = sqrt(dot3(ray.origin, ray.origin));
    let error = ROOM * (reach * (relative + POINT_RAY) + POINT_ORIGIN * start);
    let at = ray.origin + ray.direction * select(0.0, t, is_known);
    let normal = select(plane.unit, -plane.unit, slope > 0.0);
    return Point(at, error, normal, UNIT, is_known, false);
}
//#end
