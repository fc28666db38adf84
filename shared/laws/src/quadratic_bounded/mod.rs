//! Quadratic-bounded cruise control (`quadratic-bounded`).
//!
//! Gao, Yan, Li, Hu: "Multi-objective adaptive cruise control by quadratic boundedness and dynamic output feedback",
//! 2015. Four indices describe a driver's wishes. They are safety (gap error, speed error), comfort (acceleration,
//!       request), handiness (change of the request), and efficiency (rate of the gap error). The law keeps each inside
//!       its bound for every bounded acceleration of the lead. The state cannot leave an ellipsoid that is within all
//!       bounds. This holds for the state that the law takes. A gap error beyond the ellipsoid is cut off first, so the
//!       real one can be larger.
//!
//! `gains = "printed"` takes the output gains of the paper in the place of the design (`printed`).
//!
//! # Model
//!
//! ```text
//! x = [Dd, Dv, a_h, u(k-1)],  Dd = d - d_des(v_h),  Dv = v_p - v_h,  d_des(v) = c0 + c1 v + c2 v²
//! Dd' = Dv - rho(v_h) a_h,    Dv' = a_p - a_h,      a_h' = (u - a_h) / T,   rho(v) = c1 + 2 c2 v
//! h1 = (vmax - v) / (vmax - vmin),  h2 = 1 - h1,    rho_i = rho(vmin), rho(vmax)
//! x+ = sum h_i A_i x + B Du + E a_p,   y = x + noise                           (Euler, period Ts)
//! xc+ = sum h_i (Ac_i xc + L_i y),     Du = sum h_i (Fx_i xc + Fy_i y),    u(k) = u(k-1) + Du
//! ```
//!
//! The two rules are exact, not an approximation, because rho is affine in v. The paper prints the row of Dd' as
//! Z_i = [0 1 -2 v2 v_hi + v10]. Ours, [0 1 -rho_i 0], reads the sign of v10 as minus: with a plus a desired gap that
//! grows with the speed would speed the gap up.
//!
//! | symbol | field | unit |
//! | --- | --- | --- |
//! | Ts, T | `sample_time_s`, `actuator_lag_s` | s |
//! | c0, c1, c2 | `gap_constant_m`, `gap_slope_s`, `gap_curvature_s2pm` | m, s, s²/m |
//! | vmin, vmax | `least_speed_mps`, `greatest_speed_mps` | m/s |
//! | bound on a_p | `lead_acceleration_mps2` | m/s² |
//! | bounds on the noise | `gap_noise_m`, `speed_noise_mps`, `acceleration_noise_mps2` | m, m/s, m/s² |
//! | bounds on Dd, Dv, a, u | `gap_error_bound_m`, `speed_error_bound_mps`, `acceleration_bound_mps2`, `request_bound_mps2` | m, m/s, m/s², m/s² |
//! | bound on Du | `increment_bound_mps2` | m/s² |
//! | bound on Dd' | `gap_error_rate_bound_mps` | m/s |
//! | Ac_i, L_i, Fx_i, Fy_i | [`Gains`] | |
//! | P | [`Design::p`] | |
//!
//! # Use
//!
//! Cruise is following a virtual lead with Dd = 0 and Dv = v_set - v_h. The smaller of the two increments acts.
//! Whenever the lead changes, xc is reset to the value with the least V. Before the law the gap error is cut off above:
//! at `gap_error_limit_m`, and at the largest value with V <= `envelope_limit`. The virtual lead's Dv is cut off
//! likewise, on both sides. Outside the ellipsoid nothing is proven (V > 1: for example a stopped car ahead at speed).
//! The same holds outside the speeds and the lead's accelerations of the design. The law then reports so and hands over
//! to its fall-back, an explicit follower with brakes of its own (`envelope`). The output's quality is then
//! [`FallBack`](::law::Quality::FallBack), the degradation level `outside-envelope`.
//!
//! The increments are computed every Ts, whatever the control period: shorter periods hold the request in between. A
//! period that does not divide Ts delays single updates but keeps their mean rate. A longer one runs one update per
//! release and is reported as `Relaxed`: the certificate holds for Ts only.
//!
//! # Design
//!
//! Gains were made offline, by semidefinite programming, and come as a file with their certificate. [`Design::load`]
//! proves the certificate again, by Cholesky alone; a [`Design`] that is not proven does not exist.
//!
//! # How hard it can brake
//!
//! The paper calls the deceleration behind a car that cuts in "large". There the ego drives 110 km/h, and the car 80,
//! 150 m ahead when it is first seen. The shipped design brakes with 0.72 m/s²; 0.48 would do, as 73 m are to spare.
//! Findings of a search over 480 designs (gap constant, start set, weights, alpha; 460 were certified):
//!
//! | design | hardest, m/s² | paper's other figures | V |
//! | --- | --- | --- | --- |
//! | shipped | -0.72 | all hold | 1.00 |
//! | `quadratic-bounded-firm`: c0 = 8 m, start set from 17 m, gap and speed weighted tenfold, alpha 0.02 | -1.10 | all hold, most closer | 1.00 |
//! | the same, gap alone weighted, alpha 0.015: hardest with all figures | -1.15 | all hold; gap closed 8 s later | 0.98 |
//! | start set from 8 m, c0 = 5 m: hardest within the ellipsoid | -1.32 | following starts at 11.7 s, departing at 25.3 s | 1.00 |
//! | shipped, the whole gap error hidden from it | -1.05 | it leaves the ellipsoid, and the fall-back drives | 6.0 |
//!
//! So within the certificate "large" is at most about 1.3 m/s². A harder law slows down long before the gap needs it.
//! The gap then closes late or never. The program of the search is in the history of the repository, in
//! `studies/synthesis` of version 0.2.

mod certificate;
mod design;
mod envelope;
mod law;
mod model;
mod printed;

pub use certificate::{
    ClosedMatrix, ClosedState, Condition, Content, Design, Failure, Gains, closed_loop,
};
pub use design::DesignError;
pub use law::{Mode, QuadraticBounded};
pub use model::{DISTURBANCES, DisturbanceMatrix, Parameters, RULES, STATES, State, StateMatrix};

use ::law::settings::{self, Table};
use ::law::{Descriptor, Figure, Formulation, GapPolicy, Law, Reader};
use scenario::Problem;
use scenario::schema::tables;

const TABLE: Table = Table::of::<Settings>("quadratic_bounded");

pub static QUADRATIC_BOUNDED: Descriptor = Descriptor {
    name: "quadratic-bounded",
    description: "output feedback with a proven invariant ellipsoid (Gao et al. 2015)",
    source: "Gao, Yan, Li, Hu, 2015",
    table: Some(TABLE),
    formulations: &[&CERTIFIED, &PRINTED],
    formulation: |controller| {
        let settings = controller.tables.read::<Settings>(TABLE.name).unwrap_or_default();
        match settings.gains {
            GainSource::Certified => &CERTIFIED,
            GainSource::Printed => &PRINTED,
        }
    },
    gap: GapPolicy::Figure("gap_error_m"),
    measured_target: false,
    trucks_alone: false,
    build,
};

/// The meaning of the numbers in the output of a certified design.
static CERTIFIED: Formulation = Formulation {
    name: "quadratic boundedness",
    caution: None,
    modes: &["cruise", "follow", "fall-back"],
    reasons: &reasons("outside the certified range"),
    figures: &figures(Figure::new("lyapunov", "1"), "the same within the certified range"),
};

/// The same for the printed gains.
static PRINTED: Formulation = Formulation {
    name: "quadratic boundedness, gains as printed",
    caution: Some("uncertified"),
    modes: CERTIFIED.modes,
    reasons: &reasons("beyond comfortable braking"),
    figures: &figures(
        Figure::new("urgency", "1").meaning("needed over comfortable deceleration"),
        "the same, cut off above",
    ),
};

const fn reasons(of_fall_back: &'static str) -> [&'static str; 5] {
    ["none", "no target in range", "set speed demands less", "lead demands less", of_fall_back]
}

/// The figures, of which the first ends the law's range at 1; `used` says how the gap error is cut off.
const fn figures(excess: Figure, used: &'static str) -> [Figure; 8] {
    [
        excess,
        Figure::new("gap_error_m", "m").meaning("real minus desired gap; negative: too close"),
        Figure::new("gap_error_used_m", "m").meaning(used),
        Figure::new("speed_error_mps", "m/s").meaning("target's speed minus speed"),
        Figure::new("gap_error_rate_mps", "m/s"),
        Figure::new("increment_mps2", "m/s²"),
        Figure::new("cruise_increment_mps2", "m/s²"),
        Figure::new("follow_increment_mps2", "m/s²"),
    ]
}

fn build(reader: &Reader<'_>) -> Result<Box<dyn Law>, Problem> {
    let settings: Settings = reader.table(TABLE.name)?;
    reader.without(TABLE.name, settings.unused());
    let design = match &settings.design {
        None => Design::shipped(),
        Some(path) => Design::open(path).map_err(|error| {
            let key = "controller.quadratic_bounded.design";
            Problem::new(key, format!("{path}: {error}"), "a certified design")
        })?,
    };
    let law = QuadraticBounded::new(design, settings);
    Ok(Box::new(law.map_err(|error| settings::in_table(error, "controller.quadratic_bounded"))?))
}

tables! {
    /// Source of the gains.
    pub enum GainSource {
        /// The design, which is proven at every start.
        #[default]
        Certified,
        /// The paper's output equation, of which nothing is proven: for study.
        Printed,
    }
}

::law::settings! {
    /// Settings of the law outside its design, as `[controller.quadratic_bounded]` holds them.
    pub struct Settings {
        /// Targets beyond this range are not followed, m.
        sensor_range_m: f64 = 150.0, "m", 1.0..=1000.0, "Chosen.";
        /// Gap errors above this are taken for this, m.
        gap_error_limit_m: f64 = 20.0, "m", 0.0..=1000.0, "Chosen.";
        /// Gap errors that would make V larger than this are taken for smaller ones.
        envelope_limit: f64 = 0.98, "1", 0.01..=1.0, "Chosen.";
        /// Full braking of the fall-back, m/s² (positive).
        fall_back_braking_mps2: f64 = 6.0, "m/s²", 1.0..=12.0, "Chosen.";
        /// Hardest deceleration of the lead that the fall-back assumes, m/s² (positive).
        lead_deceleration_mps2: f64 = 9.0, "m/s²", 0.5..=12.0, "Chosen.";
        others {
            /// Source of the gains: the certified design, or the paper as it is printed.
            gains: GainSource = GainSource::Certified;
            /// Path of a design file; absent: the design that comes with the law.
            design: Option<String> = None;
        }
    }
}

impl Settings {
    /// The key that the chosen gains do not use: without a V there is nothing to keep within it.
    pub(super) fn unused(&self) -> &'static [&'static str] {
        match self.gains {
            GainSource::Certified => &[],
            GainSource::Printed => &["envelope_limit"],
        }
    }
}

impl settings::Settings for Settings {}
