//! The exact module against the hard cases, and against an oracle of another make
//! (`common/oracle.rs`) on random and constructed cases.
//!
//! Every run draws fresh cases; a failure prints the seed and the case.
//! `KUGELBLITZ_SEED=n cargo test --profile ci -p kugelblitz-tests --test library exact::` repeats one.

use glam::{DVec3, dvec3};
use kugelblitz::exact::{
    ExactHit, ExactRay, Real, Root, Shape, Side, nearest, plane_numbers, real, signum,
    sphere_numbers, visible_root,
};
use kugelblitz::trace::Ray;
use kugelblitz_tests::cases::{
    Case, CaseRay, cases, orthographic_case, pixel_case, plane, seed, sphere,
};
use kugelblitz_tests::hard_cases::{HardShape, hard_cases};
use kugelblitz_tests::rational;
use kugelblitz_tests::rational::{OracleRoot, q};
use num_traits::Signed;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

// ---------------------------------------------------------------------------------------------
// Judges

/// What a way of deciding says: id and bits of the f32 `t`.
type Verdict = Option<(u32, u32)>;

fn verdict(hit: Option<&ExactHit>) -> Verdict {
    hit.map(|hit| (hit.id, hit.t_f32().to_bits()))
}

fn exact_verdict(case: &Case) -> Verdict {
    verdict(nearest(&case.exact_ray(), case.objects.iter().copied()).as_ref())
}

fn oracle_verdict(case: &Case) -> Verdict {
    rational::nearest(&case.oracle_ray(), &case.objects)
        .map(|(id, root)| (id, root.to_f32().to_bits().max(1)))
}

#[test]
fn agrees_with_the_oracle() {
    let seed = seed();
    let (mut hits, mut total) = (0, 0);
    for case in cases(seed, 700) {
        let (ours, theirs) = (exact_verdict(&case), oracle_verdict(&case));
        assert_eq!(ours, theirs, "seed {seed}: {}", case.paste());
        hits += usize::from(ours.is_some());
        total += 1;
    }
    assert!(
        hits * 3 > total && hits < total,
        "the cases have become one-sided: {hits} hits of {total}, seed {seed}"
    );
}

#[test]
fn orders_all_pairs_of_roots_as_the_oracle() {
    let seed = seed();
    let (mut equal, mut n_others) = (0, 0);
    // Roots of another ray, often with another H.
    let mut before: Vec<(Root, OracleRoot)> = Vec::new();
    for case in cases(seed, 150) {
        let (ray, oracle_ray) = (case.exact_ray(), case.oracle_ray());
        let roots: Vec<(Root, OracleRoot)> = case
            .objects
            .iter()
            .filter_map(|(_, shape)| {
                let ours = visible_root(&ray, shape).map(|(root, _)| root);
                let theirs = OracleRoot::visible(&oracle_ray, shape);
                assert_eq!(ours.is_some(), theirs.is_some(), "seed {seed}: {}", case.paste());
                ours.zip(theirs)
            })
            .collect();
        n_others += before.len().min(roots.len());
        for ((a, a_oracle), (b, b_oracle)) in before.iter().zip(&roots) {
            assert_eq!(
                a.cmp(b),
                a_oracle.compare(b_oracle),
                "seed {seed}: another ray and {}",
                case.paste()
            );
        }
        for (i, (a, a_oracle)) in roots.iter().enumerate() {
            for (j, (b, b_oracle)) in roots.iter().enumerate() {
                let order = a.cmp(b);
                assert_eq!(order, a_oracle.compare(b_oracle), "seed {seed}: {}", case.paste());
                assert_eq!(order, b.cmp(a).reverse());
                equal += usize::from(i != j && order.is_eq());
            }
        }
        before = roots;
    }
    assert!(equal > 100, "only {equal} equal pairs, seed {seed}");
    assert!(n_others > 50, "only {n_others} pairs of two rays, seed {seed}");
}

#[test]
fn normals_are_the_nearest_f32_and_face_the_ray() {
    let seed = seed();
    let mut sides = [0, 0];
    for case in cases(seed, 40) {
        let ray = case.exact_ray();
        let Some(hit) = nearest(&ray, case.objects.iter().copied()) else {
            continue;
        };
        let say = || format!("seed {seed}: {}", case.paste());
        let oracle_ray = case.oracle_ray();
        let shape = case.objects.iter().find(|(id, _)| *id == hit.id).unwrap().1;
        let normal = hit.normal_f32(&ray, &shape);
        sides[usize::from(hit.side == Side::Back)] += 1;
        match shape {
            Shape::Sphere { center, radius } => {
                let root = OracleRoot::visible(&oracle_ray, &shape).unwrap();
                // Enough for ‖t·d‖/r up to 2^100 and more, in the families where it can be large.
                let t = root.below(if case.family == "exponents" { 900 } else { 420 });
                let p = oracle_ray.at(&t);
                let outward: [rational::Q; 3] =
                    std::array::from_fn(|i| (&p[i] - q(center[i])) / q(radius));
                let toward = outward
                    .iter()
                    .zip(&oracle_ray.direction)
                    .map(|(n, d)| n * d)
                    .sum::<rational::Q>();
                let sign = if hit.side == Side::Back { -1.0 } else { 1.0 };
                // A tangent ray's is 0 up to the error of t, at most t·2^-420.
                let squared: rational::Q = oracle_ray.direction.iter().map(|d| d * d).sum();
                let slack = squared * &t / q(radius) * rational::power(-420);
                assert!(toward * q(sign) <= slack, "{}", say());
                for i in 0..3 {
                    assert!(
                        rational::is_nearest_f32(normal[i], &(&outward[i] * q(sign))),
                        "component {i} of {normal:?}, {}",
                        say()
                    );
                }
            }
            Shape::Plane { normal: n, .. } => {
                let n: [rational::Q; 3] = std::array::from_fn(|i| q(n[i]));
                let squared: rational::Q = n.iter().map(|n| n * n).sum();
                let toward: rational::Q =
                    n.iter().zip(&oracle_ray.direction).map(|(n, d)| n * d).sum();
                assert_eq!(toward.is_positive(), hit.side == Side::Back, "{}", say());
                for i in 0..3 {
                    let flipped = if hit.side == Side::Back { -&n[i] } else { n[i].clone() };
                    let (low, high) = half_way(normal[i].abs());
                    let square = &n[i] * &n[i] / &squared;
                    assert!(
                        &low * &low <= square && square <= &high * &high,
                        "component {i} of {normal:?}, {}",
                        say()
                    );
                    assert!(
                        normal[i] == 0.0 || (normal[i] < 0.0) == flipped.is_negative(),
                        "{}",
                        say()
                    );
                }
            }
        }
    }
    assert!(sides.iter().all(|&n| n > 10), "{sides:?}, seed {seed}");
}

/// The midpoints to the f32 below and above.
fn half_way(x: f32) -> (rational::Q, rational::Q) {
    let middle = |other: f32| q((f64::from(x) + f64::from(other)) / 2.0);
    (if x == 0.0 { q(0.0) } else { middle(x.next_down()) }, middle(x.next_up()))
}

// ---------------------------------------------------------------------------------------------
// Would a mistake be noticed?

/// The roots of an object that are `> 0`, each with its object's id.
fn positive_roots(ray: &ExactRay, id: u32, shape: &Shape) -> Vec<(Root, u32)> {
    let roots = match *shape {
        Shape::Sphere { radius: 0.0, .. } => vec![],
        Shape::Sphere { center, radius } => sphere_numbers(ray, center, radius)
            .and_then(|numbers| numbers.roots)
            .map_or(vec![], Vec::from),
        Shape::Plane { point, normal } => plane_numbers(ray, point, normal)
            .and_then(|numbers| numbers.root)
            .map_or(vec![], |root| vec![root]),
    };
    roots.into_iter().filter(|root| root.signum() > 0).map(|root| (root, id)).collect()
}

fn first(roots: impl IntoIterator<Item = (Root, u32)>) -> Verdict {
    roots.into_iter().min().and_then(|(root, id)| {
        let t = root.to_f32();
        t.is_finite().then(|| (id, t.max(f32::from_bits(1)).to_bits()))
    })
}

fn all_roots(case: &Case) -> Vec<(Root, u32)> {
    let ray = case.exact_ray();
    case.objects.iter().flat_map(|(id, shape)| positive_roots(&ray, *id, shape)).collect()
}

/// Right: the smallest of all positive roots. What the wrong ones below start from.
fn smallest_root(case: &Case) -> Verdict {
    first(all_roots(case))
}

fn tangents_are_missed(case: &Case) -> Verdict {
    let ray = case.exact_ray();
    let touched = |shape: &Shape| match *shape {
        Shape::Sphere { center, radius } => {
            sphere_numbers(&ray, center, radius).is_some_and(|n| n.discriminant.signum() == 0)
        }
        Shape::Plane { .. } => false,
    };
    first(
        case.objects
            .iter()
            .filter(|(_, shape)| !touched(shape))
            .flat_map(|(id, shape)| positive_roots(&ray, *id, shape)),
    )
}

fn ties_go_to_the_highest_id(case: &Case) -> Verdict {
    let highest = u32::MAX;
    first(all_roots(case).into_iter().map(|(t, id)| (t, highest - id)))
        .map(|(id, t)| (highest - id, t))
}

fn ties_go_to_whoever_comes_first(case: &Case) -> Verdict {
    let best =
        all_roots(case).into_iter().reduce(|best, next| if next.0 < best.0 { next } else { best });
    first(best)
}

fn compares_rounded_roots(case: &Case) -> Verdict {
    let rounded =
        all_roots(case).into_iter().filter_map(|(t, id)| Some((Root::from(real(t.to_f64())?), id)));
    first(rounded)
}

fn far_roots_win(case: &Case) -> Verdict {
    let ray = case.exact_ray();
    first(case.objects.iter().filter_map(|(id, shape)| positive_roots(&ray, *id, shape).pop()))
}

fn order_is_reversed(case: &Case) -> Verdict {
    first(all_roots(case).into_iter().max())
}

fn zero_counts_as_visible(case: &Case) -> Verdict {
    let ray = case.exact_ray();
    for (id, shape) in &case.objects {
        if let Shape::Sphere { center, radius } = *shape
            && let Some(numbers) = sphere_numbers(&ray, center, radius)
            && numbers.k.signum() == 0
        {
            return Some((*id, 1));
        }
    }
    exact_verdict(case)
}

fn discriminant_in_f64(case: &Case) -> Verdict {
    let CaseRay::List(list_ray) = case.ray else {
        return exact_verdict(case);
    };
    let ray = case.exact_ray();
    let real_in_f64 = |shape: &Shape| match *shape {
        Shape::Sphere { center, radius } => {
            let l = center - list_ray.origin;
            let d = list_ray.direction;
            d.dot(l).powi(2) - d.dot(d) * (l.dot(l) - radius * radius) >= 0.0
        }
        Shape::Plane { .. } => true,
    };
    first(
        case.objects
            .iter()
            .filter(|(_, shape)| real_in_f64(shape))
            .flat_map(|(id, shape)| positive_roots(&ray, *id, shape)),
    )
}

/// Rays of pixels without the factor H.
fn pixels_forget_the_height(case: &Case) -> Verdict {
    let CaseRay::Pixel(pixels, x, y) = case.ray else {
        return exact_verdict(case);
    };
    let (i, j) = pixels.offset2(x, y);
    let v = pixels.view;
    let (h, n) = (v.h, f64::from(pixels.image_height));
    let direction = v.forward * n + v.right * (h * i as f64) + v.true_up * (h * j as f64);
    exact_verdict(&Case {
        ray: CaseRay::List(Ray { origin: v.position, direction }),
        ..case.clone()
    })
}

#[test]
fn a_second_way_through_the_public_numbers_agrees() {
    let seed = seed();
    for case in cases(seed, 300) {
        assert_eq!(exact_verdict(&case), smallest_root(&case), "seed {seed}: {}", case.paste());
    }
}

#[test]
fn mistakes_would_be_noticed() {
    let seed = seed();
    let truth: Vec<(Case, Verdict)> = cases(seed, 300)
        .into_iter()
        .map(|case| {
            let verdict = oracle_verdict(&case);
            (case, verdict)
        })
        .collect();
    type Judge = fn(&Case) -> Verdict;
    let judges: [(&str, Judge); 9] = [
        ("D = 0 is a miss", tangents_are_missed),
        ("ties: highest id", ties_go_to_the_highest_id),
        ("ties: first come", ties_go_to_whoever_comes_first),
        ("roots compared after rounding", compares_rounded_roots),
        ("the sign of the square root", far_roots_win),
        ("order reversed", order_is_reversed),
        ("t = 0 is visible", zero_counts_as_visible),
        ("D in f64", discriminant_in_f64),
        ("the factor H forgotten", pixels_forget_the_height),
    ];
    for (name, judge) in judges {
        let noticed = truth.iter().filter(|(case, truth)| judge(case) != *truth).count();
        println!("{name}: wrong in {noticed} of {} cases", truth.len());
        assert!(noticed > 0, "{name} goes unnoticed, seed {seed}");
    }
}

// ---------------------------------------------------------------------------------------------
// Hard cases and single facts

fn wide(v: [f32; 3]) -> DVec3 {
    dvec3(v[0].into(), v[1].into(), v[2].into())
}

/// Gives how many signs were compared: the file leaves some out.
fn assert_sign(found: i32, expected: Option<i32>, name: &str) -> usize {
    if let Some(expected) = expected {
        assert_eq!(found, expected, "{name}");
    }
    usize::from(expected.is_some())
}

#[test]
fn hard_cases_are_right() {
    let mut n_signs = 0;
    for case in hard_cases() {
        let ray =
            ExactRay::new(&Ray { origin: wide(case.origin), direction: wide(case.direction) });
        let shape = match case.shape {
            HardShape::Sphere { center, radius, sign_discriminant, sign_k, sign_toward } => {
                let numbers = sphere_numbers(&ray, wide(center), radius.into()).unwrap();
                for (found, expected) in [
                    (&numbers.discriminant, sign_discriminant),
                    (&numbers.k, sign_k),
                    (&numbers.b, sign_toward.map(|sign| -sign)),
                ] {
                    n_signs += assert_sign(found.signum(), expected, &case.name);
                }
                sphere(wide(center), radius.into())
            }
            HardShape::Plane { point, normal, sign_denominator, sign_numerator } => {
                let numbers = plane_numbers(&ray, wide(point), wide(normal)).unwrap();
                for (found, expected) in
                    [(&numbers.denominator, sign_denominator), (&numbers.numerator, sign_numerator)]
                {
                    n_signs += assert_sign(found.signum(), expected, &case.name);
                }
                plane(wide(point), wide(normal))
            }
        };
        let hit = nearest(&ray, [(1, shape)]);
        assert_eq!(hit.map(|hit| hit.t_f32().to_bits()), case.t.map(f32::to_bits), "{}", case.name);
    }
    // Three of 36 spheres but for one, two of 18 planes.
    assert_eq!(n_signs, 3 * 35 + 2 * 18);
}

/// Would notice a version of dashu that rounds.
#[test]
fn sums_and_products_are_exact() {
    let x = |value: f64| real(value).unwrap();
    let zero = Real::zero();
    let (large, small) = (x(2f64.powi(1000)), x(2f64.powi(-1000)));
    let sum = &large + &small;
    assert_eq!(&sum - &large, small);
    assert_eq!(&sum - &small, large);
    assert_eq!(&(&sum * &sum) - &(&large * &large), {
        let cross = &large * &small;
        &(&cross + &cross) + &(&small * &small)
    });
    // Subnormal, largest and signed zeros.
    let (tiny, huge) = (x(f64::from_bits(1)), x(f64::MAX));
    assert_eq!(&(&(&huge + &tiny) - &huge), &tiny);
    assert_eq!(&(&(&huge * &tiny) * &(&huge * &tiny)), &(&(&huge * &huge) * &(&tiny * &tiny)));
    assert_eq!(signum(&x(-0.0)), 0);
    assert_eq!(&x(-0.0) + &tiny, tiny);
    assert_eq!(&x(-0.0) * &tiny, zero);
    assert_eq!(signum(&(&x(-0.0) * &tiny)), 0);
    assert!(real(f64::NAN).is_none() && real(f64::INFINITY).is_none());
    // One operand that came from few bits must not decide how many the result has.
    let third = x(1.0 / 3.0);
    let mut product = x(1.0);
    for _ in 0..40 {
        product = &product * &third;
    }
    let mut rational = q(1.0);
    for _ in 0..40 {
        rational *= q(1.0 / 3.0);
    }
    assert_eq!(Root::from(product.clone()).to_decimal(500), decimal_digits(&rational, 500));
    assert_eq!(&(&product + &x(1.0)) - &x(1.0), product);
}

/// `0 < x < 1` with `n` significant digits, as `d.ddde-e`.
fn decimal_digits(x: &rational::Q, n: usize) -> String {
    let ten = q(10.0);
    let (mut scaled, mut exponent) = (x.clone(), 0);
    while scaled < q(1.0) {
        scaled *= &ten;
        exponent += 1;
    }
    for _ in 1..n {
        scaled *= &ten;
    }
    let digits = scaled.round().to_integer().to_string();
    let digits = digits.trim_end_matches('0');
    format!("{}.{}e-{exponent}", &digits[..1], &digits[1..])
}

fn list(origin: DVec3, direction: DVec3) -> ExactRay {
    ExactRay::new(&Ray { origin, direction })
}

#[test]
fn decimals() {
    let decimal = |value: f64| Root::from(real(value).unwrap()).to_decimal(20);
    assert_eq!(decimal(0.0), "0");
    assert_eq!(decimal(-0.0), "0");
    assert_eq!(decimal(1.0), "1");
    assert_eq!(decimal(-12.5), "-12.5");
    assert_eq!(decimal(0.1), "0.10000000000000000555");
    assert_eq!(decimal(100.0), "100");
    assert_eq!(decimal(1e19), "10000000000000000000");
    assert_eq!(decimal(1e20), "1e20");
    assert_eq!(decimal(1.25e-30), "1.249999999999999929e-30");
    assert_eq!(decimal(0.5f64.powi(10)), "0.0009765625");
    assert_eq!(decimal(f64::from_bits(1)), "4.9406564584124654418e-324");
    assert_eq!(decimal(f64::MAX), "1.7976931348623157081e308");
    let short = |value: f64, n: usize| Root::from(real(value).unwrap()).to_decimal(n);
    assert_eq!(short(0.125, 2), "0.12");
    assert_eq!(short(0.375, 2), "0.38");
    assert_eq!(short(9.96875, 2), "10");
    assert_eq!(short(0.00099999, 3), "0.001");
    // √2: a unit sphere seen from outside, off its centre, by a long way round.
    let ray = list(dvec3(-2.0, 0.0, 0.0), dvec3(1.0, 1.0, 0.0));
    let numbers = sphere_numbers(&ray, dvec3(0.0, 2.0, 0.0), 2.0).unwrap();
    let [near, far] = numbers.roots.unwrap();
    assert_eq!(near.to_decimal(20), "0.5857864376269049512");
    assert_eq!(far.to_decimal(20), "3.4142135623730950488");
    assert_eq!(numbers.discriminant.to_decimal(20), "32", "D = 4·(4² − 2·4)");
}

#[test]
fn pixel_numbers_are_those_of_the_contracts_direction() {
    let seed = seed();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for turn in 0..200 {
        let case = if turn % 2 == 0 { pixel_case } else { orthographic_case }(&mut rng);
        let (ray, oracle_ray) = (case.exact_ray(), case.oracle_ray());
        for (_, shape) in &case.objects {
            if let Shape::Sphere { center, radius } = *shape {
                let numbers = sphere_numbers(&ray, center, radius).unwrap();
                let [f0, f1, f2] = [0.0, 1.0, -1.0].map(|t| {
                    let p = oracle_ray.at(&q(t));
                    let l: [rational::Q; 3] = std::array::from_fn(|i| &p[i] - q(center[i]));
                    l.iter().map(|l| l * l).sum::<rational::Q>() - q(radius) * q(radius)
                });
                let a = (&f1 + &f2) / q(2.0) - &f0;
                let b = (&f1 - &f2) / q(2.0);
                let d = &b * &b - q(4.0) * &a * &f0;
                for (ours, theirs) in
                    [(&numbers.a, a), (&numbers.b, b), (&numbers.k, f0), (&numbers.discriminant, d)]
                {
                    let near = q(ours.to_f64());
                    let error = (&near - &theirs).abs();
                    let half_ulp = q(ours.to_f64().abs().next_up() - ours.to_f64().abs()) / q(2.0);
                    assert!(error <= half_ulp, "seed {seed}: {}", case.paste());
                }
            }
        }
    }
}

#[test]
fn degenerate_input_is_a_miss() {
    let object = [(1, sphere(dvec3(0.0, 0.0, 5.0), 1.0))];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let z = dvec3(0.0, 0.0, 1.0);
        assert!(nearest(&list(dvec3(bad, 0.0, 0.0), z), object).is_none());
        assert!(nearest(&list(DVec3::ZERO, dvec3(0.0, bad, 1.0)), object).is_none());
        let ray = list(DVec3::ZERO, z);
        assert!(nearest(&ray, [(1, sphere(z * bad, 1.0))]).is_none());
        assert!(nearest(&ray, [(1, sphere(z, bad))]).is_none());
        assert!(nearest(&ray, [(1, plane(z, dvec3(bad, 0.0, 1.0)))]).is_none());
    }
    assert!(nearest(&list(DVec3::ZERO, DVec3::ZERO), object).is_none());
    let ray = list(DVec3::ZERO, dvec3(0.0, 0.0, 1.0));
    assert!(nearest(&ray, [(1, plane(dvec3(0.0, 0.0, 1.0), DVec3::ZERO))]).is_none());
    assert!(nearest(&ray, [(1, sphere(dvec3(0.0, 0.0, 5.0), 0.0))]).is_none());
}

#[test]
fn t_beyond_f32_is_a_miss_and_below_it_the_smallest() {
    let ray = list(DVec3::ZERO, dvec3(0.0, 0.0, 1.0));
    let at = |z: f64| [(7, plane(dvec3(0.0, 0.0, z), dvec3(0.0, 0.0, 1.0)))];
    let edge = 2f64.powi(128) - 2f64.powi(103);
    assert!(nearest(&ray, at(edge)).is_none());
    assert_eq!(nearest(&ray, at(edge.next_down())).unwrap().t_f32(), f32::MAX);
    let tiny = nearest(&ray, at(f64::from_bits(1))).unwrap();
    assert_eq!(tiny.t_f32().to_bits(), 1);
    assert_eq!(tiny.t_f64(), f64::from_bits(1));
    // Ties to even in the subnormal range: 2.5 and 3.5 of the smallest.
    let unit = 2f64.powi(-149);
    assert_eq!(nearest(&ray, at(2.5 * unit)).unwrap().t_f32().to_bits(), 2);
    assert_eq!(nearest(&ray, at(3.5 * unit)).unwrap().t_f32().to_bits(), 4);
}

#[test]
fn sides() {
    let z = dvec3(0.0, 0.0, 1.0);
    let ray = list(DVec3::ZERO, z);
    let side = |shape: Shape| {
        let hit = nearest(&ray, [(1, shape)]).unwrap();
        (hit.side, hit.normal_f32(&ray, &shape))
    };
    let toward = [0.0, 0.0, -1.0];
    assert_eq!(side(sphere(z * 5.0, 1.0)), (Side::Front, toward));
    assert_eq!(side(sphere(z * 5.0, -1.0)), (Side::Front, toward));
    assert_eq!(side(sphere(DVec3::ZERO, 1.0)), (Side::Back, toward));
    // From the surface through the sphere, and tangent to it.
    assert_eq!(side(sphere(z, 1.0)), (Side::Back, toward));
    assert_eq!(side(sphere(dvec3(3.0, 0.0, 5.0), 3.0)), (Side::Front, [-1.0, 0.0, 0.0]));
    assert_eq!(side(plane(z, z)), (Side::Back, toward));
    assert_eq!(side(plane(z, z * -7.0)), (Side::Front, toward));
}
