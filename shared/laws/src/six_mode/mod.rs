//! Six-mode switching cruise control (`six-mode`).
//!
//! Wang, Liu, Zhang, Tong: "Simulation Test of a New Six-mode Switching Controller for Enhanced Adapt Cruise Control",
//! 2014, doi 10.3963/j.issn 1674-4861.2014.04.026. Boundaries in gap and relative speed divide driving into six modes;
//! each mode has a simple law of its own. With V_h and V_p the speeds of ego and target, V_r = V_p - V_h and R the gap:
//!
//! | mode | when V_r < 0 | when V_r > 0 | request, m/s² |
//! | --- | --- | --- | --- |
//! | 1 cruise | no target in range | no target in range | (7): 1, or k1 (V_set - V_h) near V_set |
//! | 2 approach | R >= R_w, closing at k or more | | (8): -V_r²/(2 (R - R_w)) |
//! | 3 steady | R >= R_w, closing below k | R_w <= R < R_j | -0.1 in place of (9), 0.4, or (10): k3 V_r |
//! | 4 decelerate | R_b < R < R_w | R_b < R < R_w | eight levels, -0.5 to -3.75, mean of four ([`deceleration`]) |
//! | 5 avoid | R <= R_b | R <= R_b | -a_h; [`Spacing::TimeGap`]: as hard as needed |
//! | 6 accelerate | | R >= R_j | 1 |
//!
//! ```text
//! R_x = 1.25 V below 80 km/h, else 2.5 V - 100             V = V_h in km/h
//! R_w = R_x + V_r²/(2 a) + t1 |V_r|  (closing)             (1)     R_x (opening)          (5)
//! R_b = V_h²/(2 a_h) + V_h t1 - V_p²/(2 a_p) + R0          (2) (3)
//! R_b = V_h²/(2 a_h) + V_h t1 - (V_p t_h - a_p t_h²/2) + R0        t_h = V_h/a_h + t1 < V_p/a_p  (4)
//! R_j = 5 V_r + 30/7 V_h + (V_h + V_r) + 8 (18 - V_r)/(V_r + 2) - V_r²/(2 a_h)            (6)
//! ```
//!
//! | symbol | field | unit |
//! | --- | --- | --- |
//! | R_x, R_w, R_b, R_j | [`Boundaries`] | m |
//! | R, V_h, V_r | [`Situation`] | m, m/s, m/s |
//! | a_h, a_p, a | `braking_mps2`, `lead_braking_mps2`, `warning_deceleration_mps2` | m/s² |
//! | t1 | `reaction_time_s` | s |
//! | R0 | `standstill_gap_m` | m |
//! | k, k_c | `approach_threshold_mps`, `steady_band_mps` | m/s |
//! | k1, k3 | `cruise_gain_per_s`, `steady_gain_per_s` | 1/s |
//!
//! # Three sets
//!
//! [`Variant::Literal`] is the paper, corrected only where the print is impossible:
//!
//! | printed | repaired in |
//! | --- | --- |
//! | (1) `t1 V_a`, an undefined symbol; (3) without its square; (4) with the wrong sign; (5) without `>=` | `boundaries.rs` |
//! | (7) `V_r` for the set speed's error; (8) without its minus; (9) without its k2 | `requests.rs` |
//! | figure 3 without the borders between its regions | `deceleration.rs` |
//!
//! Its requests are clamped to the law's bounds and nothing else is added. The mean of four takes the demands of the
//! last four cycles, in any mode. The paper says "the three computed before". [`Variant::Robust`] cures what makes it
//! undrivable:
//!
//! | trap of the literal law | cure |
//! | --- | --- |
//! | 1. R_w < R_b near standstill: blips of full braking | R_w at least `least_band_m` above R_b |
//! | 2. (4) falls below R0, even below zero | floor at R0 |
//! | 3. (8) has no bound as R -> R_w | limit and floor of the denominator |
//! | 4. R_j has a pole at V_r = -2 and drops 30 m up to V_r = 3 | max(V_r, 0), hysteresis |
//! | 5. no row for V_r = 0 | one order of tests for all V_r, a sign band |
//! | 6. modes 2, 3, 4, 6 ignore the set speed; no gap is regulated between R_x and R_j | minimum with the cruise law; [`Spacing::TimeGap`]: R_x is a time gap, steady driving regulates the gap |
//! | 7. avoid ends and begins again at R_b | leave above R_b + `braking_hysteresis_m` |
//! | 8. noise changes modes all the time | hysteresis, dwell, filter |
//! | 9. range edge, steps of the request, stale filter | range hysteresis, jerk limit, filter reset |
//!
//! `timegap papers six-mode` drives the literal set, the robust set and the road set. The *robust set* is
//! [`Variant::Robust`] with the paper's distances ([`Spacing::Paper`]) and eight levels ([`Parts::EqualSlices`]). The
//! *road set* is [`Parameters::default`], which `--controller six-mode` drives: the robust law with a time gap
//! ([`Spacing::TimeGap`]), braking without steps ([`Parts::Smooth`]) and numbers chosen for traffic.
//!
//! The road set was driven in random traffic: 1000 runs of two minutes. They had noise, cut-ins, cut-outs, emergency
//! stops, stop and go. It has no collision that a driver with 0.3 s of reaction could have avoided. It changes mode at
//! most 40 times in any minute (measured: 32). Behind the regulatory drive cycles its mean time gap is 2.0 to 2.5 s.
//! `tests/six_mode` and `tests/car_following` hold that, the traps and the published run.
//!
//! Trap 4 has a second half that the clamp does not remove. In the paper, (6) itself falls by about 30 m between V_r =
//! 0 and 3 m/s. Hysteresis prevents chattering.

mod avoid;
mod boundaries;
pub mod deceleration;
mod filter;
mod law;
mod modes;
mod parameters;
mod requests;

pub use boundaries::Boundaries;
pub use law::SixMode;
pub use modes::{Mode, Reason, Situation};
pub use parameters::{Parameters, Parts, Spacing, Variant};

use ::law::settings::{Table, in_table};
use ::law::{Descriptor, GapPolicy};

const TABLE: Table = Table::of::<Parameters>("six_mode");

pub static SIX_MODE: Descriptor = Descriptor {
    name: "six-mode",
    description: "six switched modes (Wang et al. 2014)",
    source: "Wang, Liu, Zhang, Tong, 2014, doi 10.3963/j.issn 1674-4861.2014.04.026",
    table: Some(TABLE),
    formulations: &[&law::FORMULATION],
    formulation: |_| &law::FORMULATION,
    gap: GapPolicy::Internal,
    measured_target: false,
    trucks_alone: false,
    build: |reader| {
        let parameters: Parameters = reader.table(TABLE.name)?;
        reader.without(TABLE.name, &parameters.unused());
        let law = SixMode::new(parameters);
        Ok(Box::new(law.map_err(|error| in_table(error, "controller.six_mode"))?))
    },
};
