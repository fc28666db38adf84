//! Pictures of the drive over time: speed, gap, time gap, time to collision, acceleration, jerk, road, modes.

use super::chart::{Axis, Bands, Curve, Mark, Plot, Row, Span, Strip, Stroke, Tone};
use super::lateral::LateralSeries;
use super::picture::{Phased, RunPicture};
use scenario::v2x::Phase;

/// Colour of the ego in every picture.
const EGO: Tone = Tone::Series(0);
/// Colour of the vehicle ahead in every picture.
const AHEAD: Tone = Tone::Series(1);
/// Colour of the law's request.
const REQUEST: Tone = Tone::Series(2);
/// Difference above which a request was bounded by the gateway, m/s².
const BOUNDED_MPS2: f64 = 0.01;

/// Speeds of the ego and the vehicle ahead, with the set speed.
pub fn speed(run: &RunPicture) -> Plot {
    let fastest = run.speed_mps.iter().map(|point| point.1).fold(0.0, f64::max);
    let level = |speed: f64| vec![(0.0, speed), (run.duration_s, speed)];
    let mut curves = vec![
        Curve::new("ego", EGO, run.speed_mps.clone()),
        Curve::new("vehicle ahead", AHEAD, run.lead_speed_mps.clone()),
    ];
    // A target far above the driven speeds would flatten the curves.
    let mut set_speed = format!("set speed {:.1} m/s", run.set_speed_mps);
    if run.set_speed_mps <= 1.6 * fastest {
        curves.push(
            Curve::new(&set_speed, Tone::Muted, level(run.set_speed_mps)).stroke(Stroke::Dashed),
        );
        set_speed.clear();
    } else {
        set_speed.push_str(", outside the chart");
    }
    if let Some(limit) = run.speed_limit_mps
        && limit <= 1.6 * fastest
        && (limit - run.set_speed_mps).abs() > 1e-9
    {
        curves.push(Curve::new("limit", Tone::Series(6), level(limit)).stroke(Stroke::Dotted));
    }
    let title = if set_speed.is_empty() { "Speed".into() } else { format!("Speed ({set_speed})") };
    let plot = Plot::over_time(&title, run.duration_s, "m/s", curves);
    plot.marked(&marks(run))
}

/// Gap to the vehicle ahead beside the desired gap; `None` without a vehicle ahead.
pub fn gap(run: &RunPicture) -> Option<Plot> {
    run.gap_m.iter().any(|point| point.1.is_finite()).then(|| {
        let curves = vec![
            Curve::new("gap", EGO, run.gap_m.clone()),
            Curve::new("desired gap", Tone::Muted, run.desired_gap_m.clone())
                .stroke(Stroke::Dashed),
            Curve::new("contact", Tone::Alarm, vec![(0.0, 0.0), (run.duration_s, 0.0)])
                .stroke(Stroke::Dotted),
        ];
        Plot::over_time("Gap to the vehicle ahead", run.duration_s, "m", curves).marked(&marks(run))
    })
}

/// Longest time gap that is drawn, s. Longer ones do not concern following.
const LONGEST_GAP_S: f64 = 10.0;
/// Longest time to collision that is drawn, s.
const LONGEST_TTC_S: f64 = 30.0;

/// Time gap to the vehicle ahead beside the desired one; `None` without a vehicle ahead.
pub fn time_gap(run: &RunPicture) -> Option<Plot> {
    let mut speeds = run.speed_mps.iter().peekable();
    let desired = run.desired_gap_m.iter().filter_map(|(time_s, gap_m)| {
        while speeds.next_if(|speed| speed.0 < *time_s).is_some() {}
        let speed_mps = speeds.peek()?.1;
        Some((*time_s, if speed_mps >= 1.0 { gap_m / speed_mps } else { f64::NAN }))
    });
    let curves = vec![
        Curve::new("time gap", EGO, up_to(LONGEST_GAP_S, &run.time_gap_s)),
        Curve::new("desired", Tone::Muted, up_to(LONGEST_GAP_S, &desired.collect::<Vec<_>>()))
            .stroke(Stroke::Dashed),
    ];
    from_zero(run, "Time gap", curves)
}

/// Time to collision; `None` if the ego never approached a vehicle ahead.
pub fn time_to_collision(run: &RunPicture) -> Option<Plot> {
    let points = up_to(LONGEST_TTC_S, &run.time_to_collision_s);
    from_zero(run, "Time to collision", vec![Curve::new("time to collision", EGO, points)])
}

/// Height of a chart with one curve, px.
const LOW_PX: f64 = 120.0;

/// A low chart of one curve.
fn low(run: &RunPicture, title: &str, unit: &str, tone: Tone, points: &[(f64, f64)]) -> Plot {
    let curve = Curve::new(title, tone, points.to_vec());
    let plot = Plot::over_time(title, run.duration_s, unit, vec![curve]).marked(&marks(run));
    Plot { height: LOW_PX, ..plot }
}

pub fn jerk(run: &RunPicture) -> Plot {
    low(run, "Jerk", "m/s³", EGO, &run.jerk_mps3)
}

/// Height and grade of the road below the ego; empty on a level road.
pub fn profile(run: &RunPicture) -> Vec<Plot> {
    if run.height_m.is_empty() {
        return Vec::new();
    }
    vec![
        low(run, "Height of the road", "m", Tone::Muted, &run.height_m),
        low(run, "Grade of the road", "%", Tone::Muted, &run.grade_percent),
    ]
}

/// The points, with gaps where a time is longer than `longest_s`.
fn up_to(longest_s: f64, points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let cut = |value: f64| if value <= longest_s { value } else { f64::NAN };
    points.iter().map(|(time_s, value)| (*time_s, cut(*value))).collect()
}

/// A plot of times whose vertical axis begins at 0; `None` if the first curve has no point.
fn from_zero(run: &RunPicture, title: &str, curves: Vec<Curve>) -> Option<Plot> {
    curves.first()?.points.iter().find(|point| point.1.is_finite())?;
    let plot = Plot::over_time(title, run.duration_s, "s", curves);
    let values = plot.curves.iter().flat_map(|curve| &curve.points).map(|point| point.1);
    let y = Axis::holding("s", values.chain([0.0]));
    Some(Plot { y, ..plot }.marked(&marks(run)))
}

pub fn acceleration(run: &RunPicture) -> Plot {
    let mut curves = vec![
        Curve::new("acceleration", EGO, run.acceleration_mps2.clone()),
        Curve::new("request of the law", REQUEST, run.request_mps2.clone()).steps(),
    ];
    if bounded(run) {
        curves.push(
            Curve::new("request after the gateway", Tone::Series(3), run.applied_mps2.clone())
                .steps()
                .stroke(Stroke::Dashed),
        );
    }
    Plot::over_time("Acceleration and request", run.duration_s, "m/s²", curves).marked(&marks(run))
}

/// Gear, torque and brakes of a truck; empty for a car.
pub fn powertrain(run: &RunPicture) -> Vec<Plot> {
    let gears = Axis::counts("number", run.gear.iter().map(|point| point.1));
    let mut plots = vec![
        Plot { y: gears, ..low(run, "Gear", "number", EGO, &run.gear) },
        low(run, "Engine torque", "kN m", REQUEST, &run.engine_torque_knm),
        low(run, "Service brakes", "kN", AHEAD, &run.service_brake_kn),
    ];
    // Leave out brakes that were never used.
    plots.retain(|plot| {
        plot.curves.iter().flat_map(|curve| &curve.points).any(|point| point.1 != 0.0)
    });
    plots.iter_mut().flat_map(|plot| &mut plot.curves).for_each(|curve| curve.steps = true);
    plots
}

/// True if the gateway changed a request before the actuators.
fn bounded(run: &RunPicture) -> bool {
    let mut requests = run.request_mps2.iter().peekable();
    let mut asked = None;
    run.applied_mps2.iter().any(|(time_s, applied)| {
        // A step's applied request appears with the next command.
        let before = asked;
        while let Some(request) = requests.next_if(|request| request.0 <= *time_s) {
            asked = Some(request.1);
        }
        before.is_some_and(|before: f64| (before - applied).abs() > BOUNDED_MPS2)
            && asked.is_some_and(|asked: f64| (asked - applied).abs() > BOUNDED_MPS2)
    })
}

/// Positions over time: the ego's front bumper, the rear bumpers of the others, the signals at their stop
/// lines.
pub fn road(run: &RunPicture) -> Plot {
    let farthest = run.position_m.last().map_or(0.0, |point| point.1);
    let above = farthest + (0.15 * farthest).max(30.0);
    let start = run.position_m.first().map_or(0.0, |point| point.1);
    let inside = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
        let cut = |at: f64| if (start..=above).contains(&at) { at } else { f64::NAN };
        points.iter().map(|(time_s, at)| (*time_s, cut(*at))).collect()
    };
    let mut curves = vec![Curve::new("ego, front", EGO, run.position_m.clone())];
    for (index, actor) in run.actors.iter().enumerate() {
        // Colours of ego, gateway and limit are reserved.
        let tone = [AHEAD, Tone::Series(3), Tone::Series(4), Tone::Series(5), Tone::Series(7)];
        let tone = tone[index % tone.len()];
        let name = format!("{}, rear", actor.name);
        curves.push(Curve::new(&name, tone, inside(&actor.in_lane_m)));
        let beside = Curve::new(&format!("{name}, beside the lane"), tone, inside(&actor.beside_m));
        curves.push(beside.stroke(Stroke::Dotted));
    }
    let mut plot = Plot::over_time("Time and space", run.duration_s, "m along the road", curves);
    let seen = run.signals.iter().filter(|signal| signal.stop_line_m <= above);
    plot.strips = seen
        .map(|signal| Strip {
            y: signal.stop_line_m,
            label: signal.name.clone(),
            spans: (signal.phases.iter())
                .map(|(from, to, phase)| (*from, *to, phase_tone(*phase)))
                .collect(),
        })
        .collect();
    for (phase, label) in
        [(Phase::Green, "green"), (Phase::Yellow, "yellow"), (Phase::Red, "red (thick)")]
    {
        let tone = phase_tone(phase);
        if plot.strips.iter().any(|strip| strip.spans.iter().any(|span| span.2 == tone)) {
            plot.strip_keys.push((label.into(), tone));
        }
    }
    plot.y = Axis::linear("m along the road", start, above);
    plot.height = 400.0;
    plot.marked(&marks(run))
}

const fn phase_tone(phase: Phase) -> Tone {
    match phase {
        Phase::Green => Tone::Go,
        Phase::Yellow => Tone::Clear,
        Phase::Red => Tone::Stop,
    }
}

/// Modes of the law, quality of its commands and degradation levels. Rows that never change from normal are
/// left out.
pub fn modes(run: &RunPicture) -> Option<Bands> {
    let mut tones = Tones::default();
    let mut rows = Vec::new();
    let rungs = run.rungs.iter();
    let rungs = rungs.map(|(who, rungs)| (format!("level of the {who}"), rungs, Some("full")));
    let law = [
        ("mode of the law".to_owned(), &run.modes, None),
        ("quality of the commands".to_owned(), &run.quality, Some("full")),
    ];
    for (name, phases, plain) in law.into_iter().chain(rungs) {
        let ordinary = phases.iter().all(|phase| Some(phase.label.as_str()) == plain);
        if !ordinary {
            rows.push(Row { name, spans: spans(phases, &mut tones) });
        }
    }
    let title = "Modes and degradation".into();
    let x = Axis::time(run.duration_s);
    (!rows.is_empty()).then(|| Bands { title, x, rows, marks: marks(run) })
}

fn spans(phases: &[Phased], tones: &mut Tones) -> Vec<Span> {
    phases
        .iter()
        .map(|phase| Span {
            from: phase.from_s,
            to: phase.to_s,
            label: phase.label.clone(),
            tone: tones.of(&phase.label),
        })
        .collect()
}

/// One colour per label.
#[derive(Default)]
struct Tones(Vec<String>);

impl Tones {
    fn of(&mut self, label: &str) -> Tone {
        let known = self.0.iter().position(|known| known == label);
        Tone::Series(known.unwrap_or_else(|| {
            self.0.push(label.to_owned());
            self.0.len() - 1
        }))
    }
}

/// Marks of the faults, numbered in order of time, and of the instants that decide requirements, by letters.
pub fn marks(run: &RunPicture) -> Vec<Mark> {
    let faults = run.faults.iter().enumerate();
    let faults = faults.map(|(index, fault)| Mark::numbered(fault.t_s, index + 1));
    let decided = run.decided.iter().map(|decided| Mark {
        x: decided.at_s,
        label: decided.letter.to_string(),
        tone: if decided.met { Tone::Muted } else { Tone::Alarm },
    });
    faults.chain(decided).collect()
}

/// Curvature of the road, lateral acceleration and lateral jerk; empty where the road has no plan.
pub fn lateral(run: &RunPicture) -> Vec<Plot> {
    let LateralSeries { curvature_perkm, acceleration_mps2, jerk_mps3 } = &run.lateral;
    if curvature_perkm.is_empty() {
        return Vec::new();
    }
    vec![
        low(run, "Curvature of the road, left positive", "1/km", Tone::Muted, curvature_perkm),
        low(run, "Lateral acceleration", "m/s²", EGO, acceleration_mps2),
        low(run, "Lateral jerk, mean over 0.5 s", "m/s³", EGO, jerk_mps3),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Chart, script_json};
    use crate::picture::{ActorPath, Decided, FaultMark, SignalPhases};

    /// A run with a fault, a cut-in, a signal and a bounded request.
    pub fn synthetic() -> RunPicture {
        let over = |value: fn(f64) -> f64| {
            (0..=100).map(|i| (f64::from(i) / 10.0, value(f64::from(i) / 10.0))).collect::<Vec<_>>()
        };
        let phase = |from_s, to_s, label: &str| Phased { from_s, to_s, label: label.into() };
        RunPicture {
            duration_s: 10.0,
            set_speed_mps: 20.0,
            position_m: over(|t| 15.0 * t),
            speed_mps: over(|_| 15.0),
            acceleration_mps2: over(|t| t.sin()),
            request_mps2: over(|t| 5.0 * t.cos()),
            applied_mps2: over(|t| t.cos()),
            lead_speed_mps: over(|t| if t < 5.0 { f64::NAN } else { 14.0 }),
            gap_m: over(|t| if t < 5.0 { f64::NAN } else { 40.0 - t }),
            time_gap_s: over(|t| if t < 5.0 { f64::NAN } else { 2.0 }),
            time_to_collision_s: over(|t| if t < 5.0 { f64::INFINITY } else { 12.0 - t }),
            jerk_mps3: over(|t| t.cos()),
            actors: vec![ActorPath {
                name: "<car>".into(),
                in_lane_m: over(|t| if t < 5.0 { f64::NAN } else { 40.0 + 14.0 * t }),
                beside_m: over(|t| if t < 5.0 { 40.0 + 14.0 * t } else { f64::NAN }),
            }],
            signals: vec![SignalPhases {
                name: "signal 1".into(),
                stop_line_m: 80.0,
                phases: vec![(0.0, 6.0, Phase::Green), (6.0, 10.0, Phase::Red)],
            }],
            modes: vec![phase(0.0, 5.0, "cruise"), phase(5.0, 10.0, "follow")],
            quality: vec![phase(0.0, 10.0, "full")],
            rungs: [
                ("controller", vec![phase(0.0, 3.0, "full"), phase(3.0, 10.0, "lead-lost")]),
                ("plant", vec![phase(0.0, 10.0, "full")]),
            ]
            .into(),
            faults: vec![FaultMark {
                t_s: 3.0,
                label: "kill controller".into(),
                outcome: String::new(),
            }],
            ..RunPicture::default()
        }
    }

    #[test]
    fn the_road_shows_signals_and_cars_beside_the_lane() {
        let plot = road(&synthetic());
        let text = script_json(&Chart::from(&plot));
        for label in ["ego, front", "\\u003ccar>, rear, beside the lane", "green", "red (thick)"] {
            assert!(text.contains(&format!("\"label\":\"{label}\"")), "{label} in {text}");
        }
        assert!(!text.contains("yellow"), "never shown");
        assert!(text.contains("signal 1"), "{text}");
    }

    #[test]
    fn faults_and_requirements_are_marked_in_every_picture() {
        let decided = vec![Decided { at_s: 5.5, letter: 'A', met: true }];
        let run = RunPicture { decided, ..synthetic() };
        let plots = [
            speed(&run),
            gap(&run).expect("a gap"),
            time_gap(&run).expect("a time gap"),
            time_to_collision(&run).expect("it approached"),
            acceleration(&run),
            jerk(&run),
            road(&run),
        ];
        for plot in plots {
            let chart = Chart::from(&plot);
            let expected = [(3.0, "1".to_owned(), "alarm"), (5.5, "A".to_owned(), "muted")];
            assert_eq!(chart.marks, expected, "{}", chart.title);
        }
    }

    #[test]
    fn rows_that_say_nothing_are_left_out() {
        let bands = modes(&synthetic()).expect("modes");
        let names: Vec<_> = bands.rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names, ["mode of the law", "level of the controller"]);
        assert!(modes(&RunPicture::default()).is_none());
        assert!(gap(&RunPicture::default()).is_none());
        assert!(time_gap(&RunPicture::default()).is_none());
        assert!(time_to_collision(&RunPicture::default()).is_none());
    }

    #[test]
    fn a_truck_shows_its_gears_and_hills_and_a_car_does_not() {
        assert!(powertrain(&synthetic()).is_empty() && profile(&synthetic()).is_empty());
        let truck = RunPicture { gear: vec![(0.0, 8.0), (5.0, 9.0)], ..synthetic() };
        let titles: Vec<_> = powertrain(&truck).into_iter().map(|plot| plot.title).collect();
        assert_eq!(titles, ["Gear"]);
        let height_m = vec![(0.0, 50.0), (10.0, 53.0)];
        let hill = RunPicture { height_m, grade_percent: vec![(0.0, 2.0)], ..synthetic() };
        assert_eq!(profile(&hill).len(), 2);
    }

    #[test]
    fn the_gateway_is_drawn_where_it_bounds() {
        let mut run = synthetic();
        assert!(bounded(&run));
        run.applied_mps2.clone_from(&run.request_mps2);
        assert!(!bounded(&run));
    }

    #[test]
    fn a_road_with_a_plan_shows_its_curves() {
        assert!(lateral(&RunPicture::default()).is_empty());
        let curvature_perkm = vec![(0.0, 0.0), (5.0, -2.0)];
        let series = LateralSeries { curvature_perkm, ..LateralSeries::default() };
        let run = RunPicture { duration_s: 5.0, lateral: series, ..RunPicture::default() };
        let titles: Vec<_> = lateral(&run).into_iter().map(|plot| plot.title).collect();
        assert_eq!(titles.len(), 3);
        assert!(titles[2].contains("0.5 s"), "{titles:?}");
    }
}
