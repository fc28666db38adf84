//! Figures 1 and 3 of the paper: the plane of modes, with the drive in it.

use super::super::runner::{Driven, Gallery};
use controller::laws::six_mode::deceleration::{PARTS, border_m};
use controller::laws::six_mode::{Boundaries, Mode, Parameters, Variant};
use report::chart::{Axis, Curve, Plot, Stroke, Tone};

/// Times at which the plane is drawn, s: the approach, the cut-in and what follows it.
const PLANES_S: [f64; 3] = [8.0, 14.0, 18.0];
const POINTS: u32 = 200;
/// Largest relative speed drawn, m/s.
const RIGHT_MPS: f64 = 9.0;

/// The planes of a drive.
pub fn of(set: &str, driven: &Driven) -> Option<Gallery> {
    let p: Parameters = driven.scenario.controller.tables.read("six_mode").ok()?;
    let planes = PLANES_S.iter().filter_map(|at_s| plane(&p, driven, *at_s));
    Some(Gallery { heading: format!("Figures 1 and 3: {set}"), plots: planes.collect() })
}

/// Gap over relative speed: the boundaries at the ego's speed of an instant, and the whole drive.
fn plane(p: &Parameters, driven: &Driven, at_s: f64) -> Option<Plot> {
    let speed_mps = driven.drive.steps.iter().find(|step| step.time_s >= at_s)?.speed_mps;
    let range_m = p.sensor_range_m;
    let boundary =
        |name: &str, stroke, from_mps: f64, distance: &dyn Fn(f64, &Boundaries) -> f64| {
            let step_mps = (RIGHT_MPS - from_mps) / f64::from(POINTS);
            let point = |index: u32| {
                let v_r = from_mps + step_mps * f64::from(index);
                let gap_m = distance(v_r, &Boundaries::of(p, speed_mps, v_r));
                (v_r, if (0.0..=range_m).contains(&gap_m) { gap_m } else { f64::NAN })
            };
            Curve::new(name, Tone::Muted, (0..=POINTS).map(point).collect()).stroke(stroke)
        };
    let mut curves = in_modes(driven);
    curves.push(boundary("R_w", Stroke::Dashed, -speed_mps, &|_, b| b.warning_m));
    curves.push(boundary("R_b", Stroke::Solid, -speed_mps, &|_, b| b.braking_m));
    curves.push(boundary("R_j", Stroke::Dotted, 0.0, &|_, b| b.following_m));
    // The literal law has figure 3's parts between R_w and R_b.
    let parts = if p.variant == Variant::Literal { 1..PARTS } else { 0..0 };
    curves.extend(parts.map(|part| {
        let border = |v_r: f64, b: &Boundaries| border_m(p, v_r, b, part);
        boundary("border of two parts", Stroke::Dotted, -speed_mps, &border)
    }));
    let title = format!("Plane of modes at {at_s:.0} s, V_h = {:.0} km/h", 3.6 * speed_mps);
    let x = Axis::linear("relative speed V_r, m/s", (-speed_mps).floor(), RIGHT_MPS);
    Some(Plot { height: 300.0, ..Plot::over(&title, x, "gap R, m", curves) })
}

/// The drive in the plane, one curve for each mode that has a target.
fn in_modes(driven: &Driven) -> Vec<Curve> {
    let modes = driven.drive.steps.iter().filter(|step| step.figures.is_some());
    let modes: Vec<_> = modes.map(|step| step.mode).collect();
    let (speeds, gaps) = (driven.figure("relative_speed_mps"), driven.figure("gap_m"));
    let curve = |(mode, name): (u32, &&str)| {
        let at = |place: usize| match modes[place] {
            Some(seen) if seen == mode => (speeds[place].1, gaps[place].1),
            _ => (f64::NAN, f64::NAN),
        };
        let places = 0..modes.len().min(speeds.len()).min(gaps.len());
        Curve::new(name, Tone::Series(mode as usize % 5), places.map(at).collect())
    };
    (1..).zip(&Mode::NAMES[1..]).map(curve).collect()
}
