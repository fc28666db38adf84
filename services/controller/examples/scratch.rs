//! scratch
use controller::predictive::{route::*, *};
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
struct Direct<'a> {
    planner: &'a mut dyn Planner,
    plan: Plan,
    road: &'a Road,
    vs: f64,
    price: f64,
    truck: Truck,
    took: Vec<f64>,
    gear: usize,
}
impl Driver for Direct<'_> {
    fn demand(&mut self, s: &Seen<'_>) -> Demand {
        let m = s.motion;
        let lim = self.vs + 5.0 / 3.6;
        let stale = self.plan.len == 0
            || m.position_m >= self.plan.segments[self.plan.binding - 1].end_m
            || m.gear != self.gear
            || (self.plan.speed_mps(0, m.position_m) - m.speed_mps).abs() > 0.6;
        if stale {
            let r = PlanRequest {
                number: 0,
                time_s: s.time_s,
                position_m: m.position_m,
                speed_mps: m.speed_mps,
                gear: m.gear,
                engine_torque_nm: m.engine_torque_nm,
                set_speed_mps: self.vs,
                speed_limit_mps: f64::INFINITY,
                time_price: self.price,
                preview: self.road.preview(m.position_m, 2100.0),
            };
            let t0 = std::time::Instant::now();
            self.planner.plan(&r, &mut self.plan);
            self.took.push(t0.elapsed().as_secs_f64() * 1e6);
            self.gear = m.gear;
        }
        let mut d = if self.plan.len == 0 {
            Demand::torque(self.truck.engine_torque_nm(
                0.12 * (self.vs - m.speed_mps),
                m.speed_mps,
                m.gear,
                s.grade,
            ))
        } else {
            let g = self.plan.segments[0];
            Demand { engine_torque_nm: g.engine_torque_nm, service_brake_n: 0.0, gear: g.gear }
        };
        let e = self.truck.engine();
        let rpm = self.truck.engine_rpm(m.speed_mps, m.gear);
        d.engine_torque_nm = d.engine_torque_nm.clamp(e.drag_torque_nm(rpm), e.max_torque_nm(rpm));
        if m.speed_mps >= lim - 0.1 {
            let h = Demand::for_acceleration(
                &self.truck,
                0.5 * (lim - m.speed_mps),
                m.speed_mps,
                m.gear,
                s.grade,
            );
            if h.engine_torque_nm < d.engine_torque_nm {
                return Demand { gear: d.gear, ..h };
            }
        }
        d
    }
}
fn main() {
    let road = road();
    let vs = 75.0 / 3.6;
    for p in Preset::ALL {
        let truck = Truck::preset(p);
        let pr = Prices::new(&truck, vs);
        let mut c = Cruise::new(&truck, vs, vs + 5.0 / 3.6);
        let base = drive(&truck, &road, vs, &mut c).unwrap();
        let f0 = base.corrected_l_per_100_km(pr.energy_gpj);
        let show = |n: &str, t: &Trip, price: f64| {
            println!(
                "{} {n}: {:.3} L/100km {:+.2}% price {price:.3} v {:.2} time {:+.3}% brk {:.1} MJ/100km eb {:.1} shifts {} range {:.1} {:.1}",
                p.name(),
                t.corrected_l_per_100_km(pr.energy_gpj),
                100.0 * (t.corrected_l_per_100_km(pr.energy_gpj) / f0 - 1.0),
                t.mean_speed_mps() * 3.6,
                100.0 * (t.time_s / base.time_s - 1.0),
                t.service_brake_j / t.length_m * 0.1,
                t.engine_brake_j / t.length_m * 0.1,
                t.shifts,
                t.speed_range_mps.0 * 3.6,
                t.speed_range_mps.1 * 3.6
            )
        };
        show("cruise", &base, 0.0);
        let secant = |f: &mut dyn FnMut(f64) -> Option<Trip>| -> Option<(Trip, f64)> {
            let mut a = 1.0;
            let mut ta = f(a)?;
            let mut b = 1.2;
            for _ in 0..8 {
                let tb = f(b)?;
                if (tb.time_s / base.time_s - 1.0).abs() < 2e-4 {
                    return Some((tb, b));
                }
                let s = (tb.time_s - ta.time_s) / (b - a);
                a = b;
                ta = tb;
                b = (a - (ta.time_s - base.time_s) / s).clamp(0.5, 3.0);
            }
            Some((ta, a))
        };
        for nodes in [300, 600] {
            let t0 = std::time::Instant::now();
            let mut n = 0;
            let r = secant(&mut |x| {
                n += 1;
                let mut b = Bound::solve(&truck, &road, vs, vs + 5.0 / 3.6, x, nodes);
                drive(&truck, &road, vs, &mut b)
            })
            .unwrap();
            let e = t0.elapsed();
            show(&format!("bound {nodes}"), &r.0, r.1);
            println!("  {n} solves, {e:?}");
        }
        for (nodes, step_m, steps) in [(60, 200.0, 10), (1, 100.0, 20)] {
            let mut pl: Box<dyn Planner> = if nodes == 1 {
                Box::new(PaperN2::new(&truck))
            } else {
                Box::new(DynamicProgramming::new(&truck, Resolution { nodes, step_m, steps }))
            };
            let mut took = vec![];
            let r = secant(&mut |x| {
                let mut d = Direct {
                    planner: pl.as_mut(),
                    plan: Plan::default(),
                    road: &road,
                    vs,
                    price: x,
                    truck,
                    took: vec![],
                    gear: 5,
                };
                let t = drive(&truck, &road, vs, &mut d);
                took = d.took;
                t
            });
            took.sort_by(f64::total_cmp);
            match r {
                Some(r) => show(&format!("dp {nodes} {step_m} {steps}"), &r.0, r.1),
                None => println!("stuck"),
            }
            println!(
                "  plans {} p50 {:.1} us p99 {:.1}",
                took.len(),
                took[took.len() / 2],
                took[took.len() * 99 / 100]
            );
        }
    }
}
