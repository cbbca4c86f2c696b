// Twin of src/gpu/before/seen_from.rs.

//#if of_scene
// Member order is checked against src/gpu/layout.rs by a test.
struct SeenFrom {
    reference: vec3<f64>,
    spread: f64,
}

struct SceneSphere {
    center: vec3<f64>,
    radius: f64,
}
//#end

//#if hierarchy
//#if double
fn sphere_seen(sphere: SceneSphere) -> SphereCertified {
    let l = sphere.center - seen_from.reference;
    let r = abs(sphere.radius);
    let l2 = dot3(l, l);
    let r2 = r * r;
    let distance = max(sqrt(l2) * LENGTH_ROOM, r) + seen_from.spread;
    let eta = UNIT * distance;
    let inner = r - KAPPA * eta;
    let outer = r + KAPPA * eta;
    let inner2 = select(-1.0, inner * inner * SQUARE_NARROWER, inner > 0.0);
    let outer2 = (outer * outer + ASIDE * eta * eta) * SQUARE_WIDER;
    let slack = UNIT * (SLACK_DISTANCE * distance + SLACK_RADIUS * outer);
    //#if point
    let k = l2 - r2;
    let k_error = K_ERROR * (l2 + r2);
    let q = Nearness(NARROWER / (k + k_error), WIDER / (k - k_error));
    //#else
    let k_error = K_DISTANCE * (distance * distance) + K_RADIUS * r2;
    let q = Nearness(0.0, 0.0);
    //#end
    return SphereCertified(l, inner2, Vec3(0.0), outer2, slack, q.low, q.high, k_error);
}
//#end
//#end
