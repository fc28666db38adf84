//! Time that planning takes: `cargo bench -p papers --bench planners`.
//!
//! Requests along a generated road of 60 km, every 100 m, at the law's speeds there. Each has 2 km of preview. Each is
//! planned `REPEATS` times; its time is the median of these. The bound is solved once per repeat.

use std::time::Instant;

use controller::law::{Plan, PlanRequest};
use controller::laws::truck::{PlannerKind, Settings, create};
use papers::trips::{Bound, Road, generated};
use truck_model::{Preset, Truck};

/// Plans of each request.
const REPEATS: usize = 11;
/// Solutions of the whole route.
const ROUTES: usize = 5;
const SET_MPS: f64 = 75.0 / 3.6;

fn main() {
    // `cargo test --benches` runs this too: one repeat shows that it works.
    let brief = !std::env::args().any(|argument| argument == "--bench");
    let repeats = |n: usize| if brief { 1 } else { n };
    let road = generated(60_000.0, 1);
    println!("{:<34} {:>5} {:>9} {:>9} {:>9}", "us per plan of 2 km", "n", "p50", "p99", "max");
    for preset in Preset::ALL {
        let truck = Truck::preset(preset);
        for kind in [PlannerKind::DynamicProgramming, PlannerKind::PaperN2] {
            let mut times_us = plans(&truck, &road, kind, repeats(REPEATS));
            print(&format!("{}: {}", preset.name(), kind.name()), &mut times_us);
        }
    }
    println!("\n{:<34} {:>5} {:>9} {:>9} {:>9}", "ms per route of 60 km", "n", "p50", "p99", "max");
    for preset in Preset::ALL {
        let truck = Truck::preset(preset);
        let mut times_ms: Vec<f64> = (0..repeats(ROUTES))
            .map(|_| {
                let begin = Instant::now();
                let bound = Bound::solve(&truck, &road, SET_MPS, SET_MPS + 1.4, 1.4, 600);
                let elapsed_ms = begin.elapsed().as_secs_f64() * 1e3;
                drop(std::hint::black_box(bound));
                elapsed_ms
            })
            .collect();
        print(&format!("{}: full-route plan, 600 nodes", preset.name()), &mut times_ms);
    }
}

fn plans(truck: &Truck, road: &Road, kind: PlannerKind, repeats: usize) -> Vec<f64> {
    let mut planner = create(&Settings::new(truck, kind));
    let mut plan = Plan::default();
    let places = (road.length_m() - 2500.0) / 100.0;
    (0..places as u64)
        .map(|place| {
            let position_m = 100.0 * place as f64 + 17.0;
            // From 65 to 78 km/h, as the truck's speed goes over hills.
            let speed_mps = (65.0 + (place % 14) as f64) / 3.6;
            let request = PlanRequest {
                number: place + 1,
                position_m,
                speed_mps,
                gear: 5,
                engine_torque_nm: 800.0,
                set_speed_mps: SET_MPS,
                speed_limit_mps: f64::INFINITY,
                time_price: 1.4,
                preview: road.preview(position_m, 2100.0),
                ..PlanRequest::default()
            };
            let mut times: Vec<f64> = (0..repeats)
                .map(|_| {
                    let begin = Instant::now();
                    let planned = planner.plan(&request, &mut plan);
                    let elapsed_us = begin.elapsed().as_secs_f64() * 1e6;
                    assert!(planned, "{kind:?} has no plan at {position_m} m");
                    elapsed_us
                })
                .collect();
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        })
        .collect()
}

/// Nearest rank.
fn print(name: &str, times: &mut [f64]) {
    times.sort_by(f64::total_cmp);
    let rank = |percent: usize| times[(times.len() * percent).div_ceil(100).max(1) - 1];
    println!(
        "{name:<34} {:>5} {:>9.1} {:>9.1} {:>9.1}",
        times.len(),
        rank(50),
        rank(99),
        rank(100)
    );
}
