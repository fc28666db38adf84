//! Synthesis of designs. The cases are the shipped ones again, designs that do not exist, and the
//! hardest certified braking for a car that cuts in.
//!
//! `cargo test --release -p synthesis --features openblas`
#![cfg(feature = "openblas")]

#[path = "../../../services/controller/tests/quadratic_bounded/plant.rs"]
mod plant;
#[path = "../../../services/controller/tests/quadratic_bounded/scenario.rs"]
mod scenario;

use controller::laws::quadratic_bounded::{Design, Parameters, Settings};
use scenario::{CUT_IN, DEPART, FOLLOW, KMH, first, run};
use synthesis::{DesignRequest, Options, SynthesisError, synthesize};

const SHIPPED: &str = include_str!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../services/controller/designs/quadratic-bounded.toml"
));
const FIRM: &str = include_str!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../services/controller/designs/quadratic-bounded-firm.toml"
));
const FIRM_DESIGN: &str = include_str!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../services/controller/designs/quadratic-bounded-firm.json"
));

fn design(request: &DesignRequest) -> Design {
    synthesize(request).expect("these bounds can be met").design
}

/// The solver's last digits depend on the BLAS. So the gains are compared, not the bytes, and the
/// certificate is verified anew in both.
#[test]
fn the_parameter_files_give_the_shipped_designs() {
    let firm = Design::load(FIRM_DESIGN).expect("its certificate holds");
    for (text, shipped) in [(SHIPPED, Design::shipped()), (FIRM, firm)] {
        let request = DesignRequest::from_toml(text).expect("the file is valid");
        assert_eq!(&request.parameters, shipped.parameters());
        let made = design(&request);
        assert_eq!(made.alpha(), shipped.alpha());
        let (ours, theirs) = (made.rules()[0].fy, shipped.rules()[0].fy);
        assert!((ours - theirs).norm() < 1e-3 * theirs.norm(), "{ours} {theirs}");
        let (ours, theirs) = (made.x_inverse(), shipped.x_inverse());
        assert!((ours - theirs).norm() < 1e-3 * theirs.norm(), "{ours} {theirs}");
        assert_eq!(Design::load(&made.to_json()), Ok(made));
    }
    assert_eq!(Parameters::reference(), *Design::shipped().parameters());
}

#[test]
fn the_line_search_ends_at_the_greatest_feasible_alpha() {
    let search =
        Options { greatest_alpha: 0.05, least_alpha: 0.02, alphas: 4, ..Options::default() };
    let found =
        synthesize(&DesignRequest { parameters: Parameters::reference(), search }).expect("some");
    let feasible: Vec<bool> = found.trials.iter().map(|t| t.outcome.is_ok()).collect();
    assert_eq!(feasible, [false, false, true], "{:?}", found.trials);
    assert_eq!(found.design.alpha(), found.trials[2].alpha);
}

#[test]
fn bounds_that_cannot_be_met_are_reported_with_every_alpha_tried() {
    let parameters = Parameters { lead_acceleration_mps2: 10.0, ..Parameters::reference() };
    let search = Options { alphas: 3, ..Options::default() };
    match synthesize(&DesignRequest { parameters, search }) {
        Err(SynthesisError::Infeasible(trials)) => assert_eq!(trials.len(), 3),
        other => panic!("{other:?}"),
    }
}

#[test]
fn bad_parameter_files_say_where() {
    let error = |text: &str| match DesignRequest::from_toml(text).map(|r| synthesize(&r)) {
        Err(e) | Ok(Err(e)) => e.to_string(),
        Ok(Ok(_)) => panic!("must be refused"),
    };
    assert!(error("[parameters]\nsample_time = 0.1").contains("line 2"));
    assert!(error(&SHIPPED.replace("0.45", "-0.45")).contains("actuator_lag_s = -0.45"));
    assert!(error(&SHIPPED.replace("0.45", "nan")).contains("actuator_lag_s = NaN"));
    assert!(error(&SHIPPED.replace("beta = 0.1", "beta = 2.0")).contains("beta = 2"));
    assert!(error(&SHIPPED.replace("alphas = 5", "alphas = 0")).contains("alphas = 0"));
}

/// The three published scenarios under one design.
struct Published {
    follow_start: f64,
    follow_steady: f64,
    depart_switch: f64,
    depart_range: f64,
    fastest: f64,
    braking_start: f64,
    least_gap_error: f64,
    last_gap_error: f64,
    hardest: f64,
    lyapunov: f64,
}

impl Published {
    fn of(design: &Design, settings: &Settings) -> Self {
        let [follow, depart, cut_in] = [FOLLOW, DEPART, CUT_IN].map(|s| run(&s, design, settings));
        let last_gap_error = cut_in.last().expect("rows").gap_error;
        let after = cut_in.iter().filter(|r| r.time > 18.0);
        Self {
            follow_start: first(&follow, 0.0, |r| r.follows),
            follow_steady: first(&follow, 0.0, |r| {
                r.follows && r.gap_error.abs() < 2.0 && r.speed_error.abs() < 0.3
            }),
            depart_switch: first(&depart, 20.0, |r| !r.follows),
            depart_range: first(&depart, 20.0, |r| r.gap > 150.0),
            fastest: depart.iter().fold(0.0, |m, r| m.max(r.speed)),
            braking_start: first(&cut_in, 17.0, |r| r.request < -0.02),
            least_gap_error: after.clone().fold(f64::INFINITY, |m, r| m.min(r.gap_error)),
            last_gap_error,
            hardest: after.fold(0.0, |m, r| m.min(r.acceleration)),
            lyapunov: [&follow, &depart, &cut_in]
                .into_iter()
                .flatten()
                .fold(0.0, |m, r| m.max(r.lyapunov)),
        }
    }

    /// True if the paper's other figures hold: 10 s, 30 s, 27.5 s, 54 s, 18 s, no overshoot, and a
    /// gap that is closed within the minute. The second value is whether all happened within the
    /// ellipsoid.
    fn holds(&self) -> bool {
        (self.follow_start - 10.0).abs() <= 0.5
            && self.follow_steady <= 30.5
            && (self.depart_switch - 27.5).abs() <= 0.5
            && (self.depart_range - 54.0).abs() <= 1.0
            && self.fastest <= 110.05 * KMH
            && (self.braking_start - 18.0).abs() <= 0.3
            && self.least_gap_error >= -0.25
            && self.last_gap_error <= 2.0
            && self.lyapunov <= 1.0
    }

    fn print(&self, name: &str) {
        println!(
            "{name:44} {:6.1} {:6.1} {:6.1} {:6.1} {:7.2} {:6.3} {:7.2} {}",
            self.follow_start,
            self.follow_steady,
            self.depart_switch,
            self.depart_range,
            self.least_gap_error,
            self.lyapunov,
            self.hardest,
            if self.holds() { "all hold" } else { "" }
        );
    }
}

/// One point of the search: c0, gap error of the start set, weight of gap and speed error, alpha.
fn candidate(c0: f64, start: f64, weights: (f64, f64), alpha: f64) -> DesignRequest {
    DesignRequest {
        parameters: Parameters {
            gap_constant_m: c0,
            start_set: vec![[start - 3.0, -5.56, 0.0, 0.0], [start, -8.34, 0.0, 0.0]],
            ..Parameters::reference()
        },
        search: Options {
            greatest_alpha: alpha,
            least_alpha: alpha,
            alphas: 1,
            weights: [weights.0, weights.1, 1.0, 1.0],
            ..Options::default()
        },
    }
}

fn header() {
    println!(
        "{:44} {:>6} {:>6} {:>6} {:>6} {:>7} {:>6} {:>7}",
        "design", "follow", "steady", "switch", "range", "gap err", "V", "braking"
    );
}

/// Result: see the module's documentation.
#[test]
fn a_certified_design_that_brakes_harder_in_the_cut_in() {
    header();
    let defaults = Settings::default();
    let shipped = Published::of(&Design::shipped(), &defaults);
    shipped.print("shipped");
    assert!(shipped.holds() && (shipped.hardest + 0.72).abs() < 0.02);
    // Found by the search below: harder by half, and every figure of the paper holds.
    let firm = Published::of(&design(&DesignRequest::from_toml(FIRM).expect("valid")), &defaults);
    firm.print("firm");
    assert!(firm.holds() && (firm.hardest + 1.10).abs() < 0.02);
    // The hardest within the ellipsoid, at the price of the times of following and departing.
    let most = Published::of(&design(&candidate(5.0, 8.0, (10.0, 10.0), 0.015)), &defaults);
    most.print("hardest within the ellipsoid");
    assert!(!most.holds() && most.lyapunov <= 1.0 && (most.hardest + 1.32).abs() < 0.02);
    // Hiding the whole gap error from the shipped design leads out of the ellipsoid. There the law's fall-back drives,
    // and braking of the certified rules is no longer visible.
    let hidden = Settings { gap_error_limit_m: 0.0, ..defaults };
    let hidden = Published::of(&Design::shipped(), &hidden);
    hidden.print("shipped, gap error hidden");
    assert!(hidden.lyapunov > 5.0 && !hidden.holds());
}

/// The search itself, 480 designs in about two minutes:
/// `cargo test --release -p synthesis --features openblas -- --ignored search --nocapture`
#[test]
#[ignore = "two minutes; its result is the test above"]
fn search_for_harder_braking() {
    header();
    let mut made = 0;
    let mut hardest = 0.0f64;
    for c0 in [5.0, 8.0, 11.0, 14.0, 17.0] {
        for start in [8.0, 10.0, 12.0, 14.0, 17.0, 20.0] {
            for weights in [(1.0, 1.0), (10.0, 1.0), (1.0, 10.0), (10.0, 10.0)] {
                for alpha in [0.01, 0.015, 0.02, 0.025] {
                    let request = candidate(c0, start, weights, alpha);
                    let Ok(found) = synthesize(&request) else { continue };
                    made += 1;
                    let result = Published::of(&found.design, &Settings::default());
                    if result.holds() {
                        hardest = hardest.min(result.hardest);
                        result.print(&format!(
                            "c0 {c0} start {start} weights {weights:?} alpha {alpha}"
                        ));
                    }
                }
            }
        }
    }
    println!("{made} certified designs of 480; hardest with all figures {hardest:.2} m/s²");
}
