//! Synthesis of designs: the shipped one again, and what cannot be had.
#![cfg(feature = "synthesize")]

#[path = "quadratic_bounded/plant.rs"]
mod plant;
#[path = "quadratic_bounded/scenario.rs"]
mod scenario;

use controller::quadratic_bounded::synthesis::{DesignRequest, Options, synthesize};
use controller::quadratic_bounded::{Design, Parameters, Settings};
use scenario::{CUT_IN, DEPART, FOLLOW, KMH, first, run};

fn row(name: &str, design: &Design, settings: &Settings) {
    let f = run(&FOLLOW, design, settings);
    let start = first(&f, 0.0, |r| r.follows);
    let steady =
        first(&f, 0.0, |r| r.follows && r.gap_error.abs() < 2.0 && r.speed_error.abs() < 0.3);
    let d = run(&DEPART, design, settings);
    let switch = first(&d, 20.0, |r| !r.follows);
    let range = first(&d, 20.0, |r| r.gap > 150.0);
    let over = d.iter().fold(0.0, |m: f64, r| m.max(r.speed)) / KMH - 110.0;
    let c = run(&CUT_IN, design, settings);
    let brake = first(&c, 17.0, |r| r.request < -0.02);
    let least =
        c.iter().filter(|r| r.time > 18.0).fold(f64::INFINITY, |m: f64, r| m.min(r.gap_error));
    let csteady =
        first(&c, 18.0, |r| r.follows && r.gap_error.abs() < 2.0 && r.speed_error.abs() < 0.3);
    let hard = c.iter().fold(0.0, |m: f64, r| m.min(r.acceleration));
    let v = f.iter().chain(&d).chain(&c).fold(0.0, |m: f64, r| m.max(r.lyapunov));
    let fhard = f.iter().fold(0.0, |m: f64, r| m.min(r.acceleration));
    println!(
        "{name:30} follow {start:.1} {steady:.1} ({fhard:.2}) depart {switch:.1} {range:.1} {over:+.3} cutin {brake:.1} gap {least:.2} steady {csteady:.1} HARD {hard:.3} V {v:.4} fy {:.3?}",
        design.rules()[0].fy.as_slice()
    );
}

#[test]
fn try_it() {
    let shipped = Design::shipped();
    for cap in [20.0, 15.0, 10.0, 5.0, 2.0, 0.0] {
        row(
            &format!("shipped cap {cap}"),
            &shipped,
            &Settings { gap_error_limit_m: cap, ..Settings::default() },
        );
    }
    let p = Parameters::reference;
    let o = Options::default;
    let sets: Vec<(String, Parameters, Options)> = vec![
        ("ref".into(), p(), o()),
        ("rule outputs".into(), p(), Options { rule_outputs: true, ..o() }),
        ("w dd 10".into(), p(), Options { weights: [10.0, 1.0, 1.0, 1.0], ..o() }),
        ("w dv 10".into(), p(), Options { weights: [1.0, 10.0, 1.0, 1.0], ..o() }),
        ("w dd,dv 10".into(), p(), Options { weights: [10.0, 10.0, 1.0, 1.0], ..o() }),
        ("w a,u .1".into(), p(), Options { weights: [1.0, 1.0, 0.1, 0.1], ..o() }),
        ("w a,u .001".into(), p(), Options { weights: [1.0, 1.0, 0.001, 0.001], ..o() }),
        ("wbar 2.0".into(), Parameters { lead_acceleration_mps2: 2.0, ..p() }, o()),
        ("wbar 1.0".into(), Parameters { lead_acceleration_mps2: 1.0, ..p() }, o()),
        ("wbar 0.5".into(), Parameters { lead_acceleration_mps2: 0.5, ..p() }, o()),
        ("du 1.0".into(), Parameters { increment_bound_mps2: 1.0, ..p() }, o()),
        ("dd 21".into(), Parameters { gap_error_bound_m: 21.0, ..p() }, o()),
        ("x0 0,-8.34".into(), Parameters { start_set: vec![[0.0, -8.34, 0.0, 0.0]], ..p() }, o()),
        ("x0 10,-8.34".into(), Parameters { start_set: vec![[10.0, -8.34, 0.0, 0.0]], ..p() }, o()),
    ];
    for (name, parameters, search) in sets {
        for alpha in [0.01, 0.02, 0.03, 0.05] {
            let search =
                Options { least_alpha: alpha, greatest_alpha: alpha, alphas: 1, ..search.clone() };
            match synthesize(&DesignRequest { parameters: parameters.clone(), search }) {
                Ok(s) => {
                    row(
                        &format!(
                            "{name} {alpha} obj {:.2}",
                            s.trials[0].outcome.clone().unwrap_or(0.0)
                        ),
                        &s.design,
                        &Settings::default(),
                    );
                    row(
                        &format!("{name} {alpha} cap 5"),
                        &s.design,
                        &Settings { gap_error_limit_m: 5.0, ..Settings::default() },
                    );
                }
                Err(e) => {
                    println!("{name} {alpha}: {}", e.to_string().lines().last().unwrap_or(""))
                }
            }
        }
    }
}
