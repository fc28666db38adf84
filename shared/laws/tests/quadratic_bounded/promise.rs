//! The guarantee itself. A bounded acceleration of the lead and bounded noise do not drive the
//! state out of the ellipsoid. No index exceeds its bound.
//!
//! First on the model, where the certificate is exact. Then on the true plant: continuous lag,
//! curved desired gap, and an adversary who chooses lead and noise and has P.

use super::plant::{DT, Pair, ask};
use law::Ego;
use laws::quadratic_bounded::{
    ClosedMatrix, ClosedState, DISTURBANCES, Design, QuadraticBounded, Settings, State, closed_loop,
};
use nalgebra::SVector;
use rand_core::Rng;
use rand_pcg::Pcg64;

type Disturbance = SVector<f64, DISTURBANCES>;

fn uniform(rng: &mut Pcg64, low: f64, high: f64) -> f64 {
    low + (high - low) * random::uniform(rng)
}

/// A point of the sphere, by rejection from the cube.
fn direction(rng: &mut Pcg64) -> ClosedState {
    loop {
        let v = ClosedState::from_fn(|_, _| uniform(rng, -1.0, 1.0));
        let square = v.norm_squared();
        if (1e-3..=1.0).contains(&square) {
            return v / square.sqrt();
        }
    }
}

/// The ellipsoid's boundary as the image of the sphere.
fn boundary(design: &Design) -> ClosedMatrix {
    let inverse = design.p().try_inverse().expect("P is positive definite");
    inverse.cholesky().expect("so is its inverse").l()
}

/// The blend of the two rules at one speed: Phi and G.
fn blended(design: &Design, speed: f64) -> (ClosedMatrix, nalgebra::SMatrix<f64, 8, DISTURBANCES>) {
    let p = design.parameters();
    let mut sum = (ClosedMatrix::zeros(), nalgebra::SMatrix::zeros());
    for ((h, rho), gains) in
        p.memberships(speed).into_iter().zip(p.rule_derivatives_s()).zip(design.rules())
    {
        let (phi, g) = closed_loop(p, rho, gains);
        sum.0 += phi * h;
        sum.1 += g * h;
    }
    sum
}

/// The vertex of the disturbances that makes the next V greatest to first order.
fn worst(design: &Design, speed: f64, z: &ClosedState) -> Disturbance {
    let (phi, g) = blended(design, speed);
    let gradient = g.transpose() * (design.p() * (phi * z));
    let bounds = design.parameters().disturbance_bounds();
    Disturbance::from_fn(|j, _| bounds[j].copysign(gradient[j]))
}

#[test]
fn no_vertex_leads_out_of_the_ellipsoid_in_one_sample() {
    for design in designs() {
        let (p, to_boundary) = (design.parameters(), boundary(&design));
        let bounds = p.disturbance_bounds();
        let mut rng = Pcg64::new(1, 1);
        let mut most = 0.0f64;
        for _ in 0..20_000 {
            let z = to_boundary * direction(&mut rng);
            let speed = uniform(&mut rng, p.least_speed_mps, p.greatest_speed_mps);
            let (phi, g) = blended(&design, speed);
            for signs in 0..1u32 << DISTURBANCES {
                let w =
                    Disturbance::from_fn(
                        |j, _| {
                            if signs >> j & 1 == 1 { bounds[j] } else { -bounds[j] }
                        },
                    );
                most = most.max(design.lyapunov(&(phi * z + g * w)));
            }
        }
        // The worst point of the boundary, by ascent: V is convex, so this climbs.
        for (rho, gains) in p.rule_derivatives_s().into_iter().zip(design.rules()) {
            let (phi, g) = closed_loop(p, rho, gains);
            for signs in 0..1u32 << DISTURBANCES {
                let w =
                    Disturbance::from_fn(
                        |j, _| {
                            if signs >> j & 1 == 1 { bounds[j] } else { -bounds[j] }
                        },
                    );
                let mut z = to_boundary * direction(&mut rng);
                for _ in 0..200 {
                    let ascent = to_boundary.transpose()
                        * (phi.transpose() * design.p() * (phi * z + g * w));
                    z = to_boundary * ascent.normalize();
                }
                most = most.max(design.lyapunov(&(phi * z + g * w)));
            }
        }
        println!("largest V after one sample from the boundary: {most:.9}");
        assert!(most <= 1.0, "V = {most}");
        assert!(most > 0.98, "the search for the worst case has not found it: {most}");
    }
}

/// The shipped design and the firmer one.
fn designs() -> [Design; 2] {
    let firm =
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/quadratic-bounded-firm.json"));
    [Design::shipped(), Design::load(firm).expect("its certificate holds")]
}

/// Largest value of V and of each index over its bound.
#[derive(Debug, Default)]
struct Most {
    lyapunov: f64,
    /// The same five seconds after the start and later, when the start has no effect any more.
    later: f64,
    /// Dd, Dv, a, u, Du, Dd', each relative to its bound.
    indices: [f64; 6],
}

/// Follows an adversary on the true plant for a minute; gains only, no cruise.
fn duel(design: &Design, rng: &mut Pcg64, strategy: u32, most: &mut Most) {
    let p = design.parameters();
    let x_inverse = design.x_inverse();
    // Engaged in the ellipsoid: x' X^-1 x = 0.999 with the best controller state.
    let mut x = State::from(p.state_bounds());
    x.apply(|bound| *bound *= uniform(rng, -1.0, 1.0));
    let x = x * (0.999 / (x.transpose() * x_inverse * x)[(0, 0)]).sqrt();
    let speed = uniform(rng, 16.0, 30.0);
    let mut pair = Pair {
        ego: Ego { speed_mps: speed, acceleration_mps2: x[2], ..Ego::default() },
        gap: p.desired_gap_m(speed) + x[0],
        lead_speed: speed + x[1],
    };
    let mut request = x[3];
    let mut xc = design.reset() * x;
    let mut lead = 0.0;
    let per_sample = (p.sample_time_s / DT).round() as u32;
    for k in 0..600 {
        let ego = pair.ego;
        let v = ego.speed_mps;
        let x = State::new(
            pair.gap - p.desired_gap_m(v),
            pair.lead_speed - v,
            ego.acceleration_mps2,
            request,
        );
        let z = ClosedState::from_fn(|i, _| if i < 4 { x[i] } else { xc[i - 4] });
        let lyapunov = design.lyapunov(&z);
        most.lyapunov = most.lyapunov.max(lyapunov);
        if k >= 50 {
            most.later = most.later.max(lyapunov);
        }
        let bounds = p.disturbance_bounds();
        let mut w = worst(design, v, &z);
        match strategy {
            // Three adversaries: one has P; one has a lead that brakes and accelerates hard at
            // random; one does everything at random.
            0 => lead = w[0],
            1 => {
                if uniform(rng, 0.0, 1.0) < 0.03 {
                    lead = bounds[0] * [-1.0, 0.0, 1.0][rng.next_u32() as usize % 3];
                }
            }
            _ => {
                lead = uniform(rng, -bounds[0], bounds[0]);
                w = Disturbance::from_fn(|j, _| uniform(rng, -bounds[j], bounds[j]));
            }
        }
        // The model holds for ego speeds between the two rules: keep the lead well within.
        let ahead = pair.lead_speed + lead * p.sample_time_s;
        let acceleration = if (12.0..32.0).contains(&ahead) { lead } else { 0.0 };
        let y = x + State::new(w[1], w[2], w[3], 0.0);
        let blend = p.memberships(v);
        let (mut increment, mut next) = (0.0, State::zeros());
        for (h, gains) in blend.into_iter().zip(design.rules()) {
            increment += h * (gains.fx.dot(&xc) + gains.fy.dot(&y));
            next += (gains.ac * xc + gains.l * y) * h;
        }
        xc = next;
        request += increment;
        let indices = [x[0], x[1], x[2], request, increment, x[1] - p.gap_derivative_s(v) * x[2]];
        let [dd, dv, a, u] = p.state_bounds();
        let limits = [dd, dv, a, u, p.increment_bound_mps2, p.gap_error_rate_bound_mps];
        for ((m, value), limit) in most.indices.iter_mut().zip(indices).zip(limits) {
            *m = m.max(value.abs() / limit);
        }
        for _ in 0..per_sample {
            pair.advance(request, acceleration);
        }
        assert!((5.0..36.0).contains(&pair.ego.speed_mps), "left the modelled speeds: {pair:?}");
    }
}

#[test]
fn no_adversary_leaves_the_ellipsoid_on_the_true_plant() {
    for design in designs() {
        let mut most = Most::default();
        let mut rng = Pcg64::new(2, 2);
        for run in 0..300 {
            duel(&design, &mut rng, run % 3, &mut most);
        }
        println!("true plant, 300 duels of a minute: {most:?}");
        assert!(most.lyapunov <= 1.0, "{most:?}");
        assert!(most.indices.iter().all(|i| *i <= 1.0), "{most:?}");
        assert!(most.later > 0.2, "the adversaries are too weak to prove anything: {most:?}");
    }
}

/// The whole law, cruise included, behind a lead that does as it likes within its bound.
#[test]
fn the_whole_law_stays_in_the_envelope() {
    let design = Design::shipped();
    let p = design.parameters().clone();
    let mut law = QuadraticBounded::new(design, Settings::default()).expect("valid settings");
    let mut rng = Pcg64::new(3, 3);
    let (mut most, mut least_gap_error) = (0.0f64, f64::INFINITY);
    for _ in 0..50 {
        law::Law::reset(&mut law);
        let speed = uniform(&mut rng, 20.0, 30.0);
        let mut pair = Pair {
            ego: Ego { speed_mps: speed, ..Ego::default() },
            gap: p.desired_gap_m(speed) + uniform(&mut rng, 20.0, 80.0),
            lead_speed: speed - uniform(&mut rng, 0.0, 5.0),
        };
        let set_speed = speed + uniform(&mut rng, -2.0, 4.0);
        // A lead that comes into range is no slower than the start set allows, noise included.
        let slowest = set_speed - 8.2;
        let (mut lead, mut before) = (0.0, 0.0);
        for k in 0..1200 {
            if uniform(&mut rng, 0.0, 1.0) < 0.03 {
                lead = p.lead_acceleration_mps2 * [-1.0, 0.0, 1.0][rng.next_u32() as usize % 3];
            }
            let ahead = pair.lead_speed + lead * p.sample_time_s;
            let acceleration = if (slowest..32.0).contains(&ahead) { lead } else { 0.0 };
            let time = f64::from(k) * p.sample_time_s;
            let mut target = pair.target();
            target.gap_m += uniform(&mut rng, -p.gap_noise_m, p.gap_noise_m);
            target.relative_speed_mps += uniform(&mut rng, -p.speed_noise_mps, p.speed_noise_mps);
            let ego = pair.ego;
            let out = ask(&mut law, (time, p.sample_time_s), ego, Some(target), set_speed);
            let request = out.request_mps2();
            assert!(request.abs() <= p.request_bound_mps2);
            assert!((request - before).abs() <= p.increment_bound_mps2 + 1e-12);
            before = request;
            most = most.max(out.figures[0]);
            least_gap_error = least_gap_error.min(pair.gap - p.desired_gap_m(ego.speed_mps));
            for _ in 0..10 {
                pair.advance(request, acceleration);
            }
        }
    }
    println!("whole law: largest V {most:.4}, least gap error {least_gap_error:.2} m");
    assert!(most <= 1.0, "V = {most}");
    assert!(least_gap_error >= -p.gap_error_bound_m);
}
