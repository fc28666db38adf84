//! The three published scenarios as closed loops.

use crate::plant::{DT, Pair, ask};
use law::Ego;
use laws::quadratic_bounded::{Design, Mode, QuadraticBounded, Settings};

pub(crate) const KMH: f64 = 1.0 / 3.6;
const PERIOD: f64 = 0.1;
const SET_SPEED: f64 = 110.0 * KMH;

/// State at one release.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub(crate) time: f64,
    pub(crate) follows: bool,
    pub(crate) gap: f64,
    pub(crate) gap_error: f64,
    pub(crate) speed_error: f64,
    pub(crate) speed: f64,
    pub(crate) acceleration: f64,
    pub(crate) request: f64,
    pub(crate) lyapunov: f64,
}

/// Lead acceleration as a function of time, first time it is seen, gap, ego and lead speed.
pub(crate) struct Scenario {
    lead: fn(f64) -> f64,
    seen_from: f64,
    gap: Option<f64>,
    speed: f64,
    lead_speed: f64,
    duration: f64,
}

/// Ego at its set speed; lead at 90, 150 m ahead; to 100 from 40 s on.
pub(crate) const FOLLOW: Scenario = Scenario {
    lead: |t| if (40.0..40.0 + 10.0 * KMH / 0.7).contains(&t) { 0.7 } else { 0.0 },
    seen_from: 0.0,
    gap: Some(150.0),
    speed: 110.0 * KMH,
    lead_speed: 90.0 * KMH,
    duration: 70.0,
};

/// Following at 79 behind 80; the lead goes to 120 between 20 and 30 s.
pub(crate) const DEPART: Scenario = Scenario {
    lead: |t| if (20.0..30.0).contains(&t) { 4.0 * KMH } else { 0.0 },
    seen_from: 0.0,
    gap: None,
    speed: 79.0 * KMH,
    lead_speed: 80.0 * KMH,
    duration: 70.0,
};

/// Ego at its set speed; a car at 80, 300 m ahead, comes into the path at 18 s.
pub(crate) const CUT_IN: Scenario = Scenario {
    lead: |_| 0.0,
    seen_from: 18.0,
    gap: Some(300.0),
    speed: 110.0 * KMH,
    lead_speed: 80.0 * KMH,
    duration: 60.0,
};

pub(crate) fn run(scenario: &Scenario, design: &Design, settings: &Settings) -> Vec<Row> {
    let mut law = QuadraticBounded::new(design.clone(), settings.clone()).expect("valid settings");
    let p = law.design().parameters().clone();
    let ego = Ego { speed_mps: scenario.speed, ..Ego::default() };
    let gap = scenario.gap.unwrap_or(p.desired_gap_m(scenario.speed));
    let mut pair = Pair { ego, gap, lead_speed: scenario.lead_speed };
    let mut request = 0.0;
    let mut rows = Vec::new();
    for step in 0..(scenario.duration / DT).round() as u32 {
        let time = f64::from(step) * DT;
        if step % 10 == 0 {
            let target = (time >= scenario.seen_from).then(|| pair.target());
            let out = ask(&mut law, (time, PERIOD), pair.ego, target, SET_SPEED);
            request = out.request_mps2();
            rows.push(Row {
                time,
                follows: law.mode() == Some(Mode::Follow),
                gap: pair.gap,
                gap_error: pair.gap - p.desired_gap_m(pair.ego.speed_mps),
                speed_error: pair.lead_speed - pair.ego.speed_mps,
                speed: pair.ego.speed_mps,
                acceleration: pair.ego.acceleration_mps2,
                request,
                lyapunov: out.figures[0],
            });
        }
        pair.advance(request, (scenario.lead)(time));
    }
    rows
}

/// Time of the first row from `from` on that satisfies the condition.
pub(crate) fn first(rows: &[Row], from: f64, condition: impl Fn(&Row) -> bool) -> f64 {
    rows.iter().find(|r| r.time >= from && condition(r)).map_or(f64::NAN, |r| r.time)
}
