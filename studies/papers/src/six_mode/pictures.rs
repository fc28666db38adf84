//! Figures 1, 3 and 6 of the paper, with a drive in them.

use super::super::Gallery;
use super::super::runner::Driven;
use super::{SWITCHES, changes, modes};
use controller::laws::six_mode::deceleration::{PARTS, border_m};
use controller::laws::six_mode::{Boundaries, Mode, Parameters, Variant};
use group::DriveStep;
use report::chart::{Axis, Curve, Plot, Point, Stroke, Tone};

/// Times at which the plane is drawn, s: the approach, the cut-in and what follows it.
const PLANES_S: [f64; 3] = [8.0, 14.0, 18.0];
/// Points of a boundary.
const POINTS: u32 = 200;
/// Largest relative speed drawn, m/s.
const RIGHT_MPS: f64 = 9.0;

/// Figures 1 and 6, and figure 3 of the literal law, whose regions are the paper's.
pub fn of(set: &str, driven: &Driven) -> Vec<Gallery> {
    let parameters = driven.scenario.controller.tables.read::<Parameters>("six_mode");
    let Ok(p) = parameters else { return Vec::new() };
    let mut planes: Vec<_> = PLANES_S.iter().filter_map(|at_s| plane(&p, driven, *at_s)).collect();
    planes.extend(partition(&p, driven).filter(|_| p.variant == Variant::Literal));
    vec![
        Gallery { heading: format!("Figures 1 and 3: {set}"), plots: planes },
        Gallery { heading: format!("Figure 6: {set}"), plots: over_time(driven) },
    ]
}

/// Figure 1: the plane of modes at the ego's speed of an instant, and the whole drive in it.
fn plane(p: &Parameters, driven: &Driven, at_s: f64) -> Option<Plot> {
    let speed_mps = step_at(driven, at_s)?.speed_mps;
    let range_m = p.sensor_range_m;
    let line = |name: &str, stroke, distance_m: &dyn Fn(&Boundaries) -> f64, from_mps: f64| {
        boundary(name, p, speed_mps, from_mps, &|_, b| distance_m(b)).stroke(stroke)
    };
    let k_mps = -p.approach_threshold_mps;
    let above_m = boundaries(p, speed_mps, k_mps).warning_m;
    let mut curves = in_modes(driven);
    curves.push(line("R_w", Stroke::Dashed, &|b| b.warning_m, -speed_mps));
    curves.push(line("R_b", Stroke::Solid, &|b| b.braking_m, -speed_mps));
    curves.push(line("R_j", Stroke::Dotted, &|b| b.following_m, 0.0));
    let k = Curve::new("V_r = -k", Tone::Muted, vec![(k_mps, above_m), (k_mps, range_m)]);
    curves.push(k.stroke(Stroke::Dotted));
    let title = format!("Plane of modes at {at_s:.0} s, V_h = {:.0} km/h", 3.6 * speed_mps);
    Some(in_plane(&title, p, -speed_mps, curves).with_points(switches(driven)))
}

/// Figure 3: the eight parts of the decelerate mode at the speed with which the drive enters it.
fn partition(p: &Parameters, driven: &Driven) -> Option<Plot> {
    let entered =
        driven.drive.steps.iter().find(|step| step.mode == Some(Mode::Decelerate.index()))?;
    let speed_mps = entered.speed_mps;
    let mut curves = in_modes(driven);
    for part in 0..=PARTS {
        let (name, stroke) = match part {
            0 => ("R_w", Stroke::Dashed),
            2 | 5 => ("border of two regions", Stroke::Solid),
            PARTS => ("R_b", Stroke::Solid),
            _ => ("border of two parts", Stroke::Dotted),
        };
        let border = |v_r: f64, b: &Boundaries| border_m(p, v_r, b, part);
        curves.push(boundary(name, p, speed_mps, -speed_mps, &border).stroke(stroke));
    }
    let title = format!(
        "Parts of the decelerate mode at {:.1} s, V_h = {:.0} km/h",
        entered.time_s,
        3.6 * speed_mps
    );
    Some(in_plane(&title, p, -speed_mps, curves))
}

/// Gap over relative speed, up to the sensor's range.
fn in_plane(title: &str, p: &Parameters, from_mps: f64, curves: Vec<Curve>) -> Plot {
    let x = Axis::linear("relative speed V_r, m/s", from_mps.floor(), RIGHT_MPS);
    let range_m = p.sensor_range_m;
    let curves = curves.into_iter().map(|curve| clipped(curve, range_m)).collect();
    Plot { height: 300.0, ..Plot::over(title, x, "gap R, m", curves) }
}

/// The curve without what lies outside the plane.
fn clipped(mut curve: Curve, range_m: f64) -> Curve {
    for point in &mut curve.points {
        if !(0.0..=range_m).contains(&point.1) || point.0 > RIGHT_MPS {
            point.1 = f64::NAN;
        }
    }
    curve
}

/// A boundary over the relative speed.
fn boundary(
    name: &str,
    p: &Parameters,
    speed_mps: f64,
    from_mps: f64,
    distance_m: &dyn Fn(f64, &Boundaries) -> f64,
) -> Curve {
    let at = |index: u32| {
        let relative_mps = from_mps + (RIGHT_MPS - from_mps) * f64::from(index) / f64::from(POINTS);
        (relative_mps, distance_m(relative_mps, &boundaries(p, speed_mps, relative_mps)))
    };
    Curve::new(name, Tone::Muted, (0..=POINTS).map(at).collect())
}

fn boundaries(p: &Parameters, speed_mps: f64, relative_mps: f64) -> Boundaries {
    match p.variant {
        Variant::Literal => Boundaries::literal(p, speed_mps, relative_mps),
        Variant::Robust => Boundaries::robust(p, speed_mps, relative_mps),
    }
}

/// The drive in the plane, one curve for each mode that has a target.
fn in_modes(driven: &Driven) -> Vec<Curve> {
    let seen = seen(driven);
    (1..)
        .zip(&Mode::NAMES[1..])
        .map(|(mode, name)| {
            let at = |&(step, point): &(&DriveStep, (f64, f64))| {
                if step.mode == Some(mode) { point } else { (f64::NAN, f64::NAN) }
            };
            Curve::new(name, Tone::Series(mode as usize % 5), seen.iter().map(at).collect())
        })
        .collect()
}

/// Relative speed and gap at every control cycle that has a target.
fn seen(driven: &Driven) -> Vec<(&DriveStep, (f64, f64))> {
    let relative = driven.figure("relative_speed_mps").into_iter().zip(driven.figure("gap_m"));
    let cycles = driven.drive.steps.iter().filter(|step| step.figures.is_some());
    let points = cycles.zip(relative).map(|(step, ((_, v_r), (_, gap_m)))| (step, (v_r, gap_m)));
    points.filter(|(step, _)| step.mode != Some(Mode::Cruise.index())).collect()
}

/// The instants at which the drive changes its mode, where it has a target.
fn switches(driven: &Driven) -> Vec<Point> {
    let seen = seen(driven);
    let point = |(_, to, at_s): &(u32, u32, f64)| {
        let (_, (x, y)) = seen.iter().find(|(step, _)| step.time_s >= *at_s)?;
        let label = format!("{at_s:.1} s: {}", Mode::NAMES[*to as usize - 1]);
        (*to != 1).then_some(Point { x: *x, y: *y, label })
    };
    changes(&modes(driven)).iter().filter_map(point).collect()
}

fn step_at(driven: &Driven, at_s: f64) -> Option<&DriveStep> {
    driven.drive.steps.iter().find(|step| step.time_s >= at_s)
}

/// Figure 6: distances, mode, speeds and accelerations over time.
fn over_time(driven: &Driven) -> Vec<Plot> {
    let until_s = driven.scenario.duration_s.value();
    let steps = |value: fn(&DriveStep) -> f64| -> Vec<(f64, f64)> {
        driven.drive.steps.iter().map(|step| (step.time_s, value(step))).collect()
    };
    let has_target: Vec<f64> = seen(driven).iter().map(|(step, _)| step.time_s).collect();
    let distance = |name: &str, figure, stroke| {
        let mut points = driven.figure(figure);
        points.retain(|(time_s, _)| has_target.binary_search_by(|t| t.total_cmp(time_s)).is_ok());
        Curve::new(name, Tone::Muted, points).stroke(stroke)
    };
    let gap = steps(|step| step.gap_m.unwrap_or(f64::NAN));
    let mode = modes(driven).iter().map(|(time_s, mode)| (*time_s, f64::from(*mode))).collect();
    let printed = SWITCHES.iter().map(|switch| Point {
        x: switch.at_s,
        y: f64::from(switch.to),
        label: format!("printed: {} to {} at {:.0} s", switch.from, switch.to, switch.at_s),
    });
    let one = |name: &str, points| Curve::new(name, Tone::Series(0), points);
    vec![
        Plot::over_time(
            "Gap and boundaries",
            until_s,
            "m",
            vec![
                one("gap R", gap),
                distance("R_w", "r_w_m", Stroke::Dashed),
                distance("R_b", "r_b_m", Stroke::Solid),
            ],
        ),
        Plot::over_time(
            "Mode, printed switches as rings (figure 6b)",
            until_s,
            "1 to 6",
            vec![one("mode", mode).steps()],
        )
        .with_points(printed.collect()),
        Plot::over_time(
            "Speeds (figure 6c)",
            until_s,
            "km/h",
            vec![
                one("ego", steps(|step| 3.6 * step.speed_mps)),
                Curve::new(
                    "vehicle ahead",
                    Tone::Muted,
                    steps(|step| 3.6 * step.lead_speed_mps.unwrap_or(f64::NAN)),
                ),
            ],
        ),
        Plot::over_time(
            "Acceleration",
            until_s,
            "m/s²",
            vec![
                one("ego", steps(|step| step.acceleration_mps2)),
                Curve::new(
                    "request",
                    Tone::Muted,
                    steps(|step| step.request_mps2.unwrap_or(f64::NAN)),
                )
                .steps(),
            ],
        ),
    ]
}
