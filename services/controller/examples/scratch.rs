use controller::predictive::{Prices, route::*};
use truck_model::*;
fn road() -> Road {
    let t = std::fs::read_to_string("tests/data/predictive-road-synth-50m.csv").unwrap();
    let h: Vec<f64> = t
        .lines()
        .filter(|l| !l.starts_with('#'))
        .map(|l| l.split(',').nth(1).unwrap().parse().unwrap())
        .collect();
    Road::from_heights(50.0, &h)
}
fn main() {
    let road = road();
    let vs = 75.0 / 3.6;
    for p in Preset::ALL {
        let truck = Truck::preset(p);
        let pr = Prices::new(&truck, vs);
        for (lim) in [1.0, 3.0, 5.0, 7.0] {
            let mut c = Cruise::new(&truck, vs, vs + lim / 3.6);
            let t0 = std::time::Instant::now();
            let t = drive(&truck, &road, vs, &mut c).unwrap();
            println!(
                "{} lim+{lim}: {:.2} L/100km v {:.2} time {:.1} brk {:.1} MJ/100km eb {:.1} shifts {} range {:.1} {:.1} took {:?}",
                p.name(),
                t.corrected_l_per_100_km(pr.energy_gpj),
                t.mean_speed_mps() * 3.6,
                t.time_s,
                t.service_brake_j / t.length_m * 0.1,
                t.engine_brake_j / t.length_m * 0.1,
                t.shifts,
                t.speed_range_mps.0 * 3.6,
                t.speed_range_mps.1 * 3.6,
                t0.elapsed()
            );
        }
    }
}
