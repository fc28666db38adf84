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
fn regen() {
    for name in ["quadratic-bounded", "quadratic-bounded-firm"] {
        let text = std::fs::read_to_string(format!("designs/{name}.toml")).unwrap();
        let s = synthesize(&DesignRequest::from_toml(&text).unwrap()).unwrap();
        println!("{:?}", s.trials);
        row(name, &s.design, &Settings::default());
        std::fs::write(format!("designs/{name}.json"), s.design.to_json()).unwrap();
        assert_eq!(Design::load(&s.design.to_json()).unwrap(), s.design);
    }
}
