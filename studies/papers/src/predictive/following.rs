//! The following figure, and requirements beyond it.
//!
//! The paper describes four points of its figure in words; the scenario's road and lead are laid out
//! after them. Each point is one or two rows.

use super::pictures::{height, over, over_distance};
use crate::row::{EXACT, Kind, Row, paper, requirement, within};
use crate::runner::{Driven, Part, Piece, Runner};
use crate::{Gallery, Pictures};
use controller::laws::truck::{GapKeys, Spacing};
use group::Error;
use group::report::Outcome;
use group::{DriveStep, PowertrainStep};
use report::chart::{Curve, Stroke, Tone};
use truck_model::{FUEL_DENSITY_GPL, Preset, Truck};

/// End of the figure, m.
const FIGURE_M: f64 = 3500.0;
/// Time when the lead begins to brake in the scenario, s.
const LEAD_BRAKES_S: f64 = 96.0;
/// Reason of the tolerance of what the paper shows in its figure.
const PLOT: &str = "described in words and shown in a plot without a scale";
/// Largest ratio of the first deceleration to the largest one that still is "small, then larger".
const SMALL_BEFORE_LARGE: f64 = 0.7;

/// Road ahead of the lead whose grade counts in the desired gap, m.
const LEAD_ROAD_M: f64 = 300.0;
/// Assumptions behind the rows of the figure.
const ROAD: &str = "the road and the lead of the scenario: the paper's are not printed";

/// Shortest headway, s.
const MIN_HEADWAY_S: f64 = 1.0;

/// The law alone: the paper's truck has no emergency brake, and its radar gives objects.
const ALONE: [&str; 2] = ["perception.radar.model=\"object-list\"", "aebs.enabled=false"];

/// The figure, the fuel in traffic, and the lead that brakes before each truck.
pub fn pieces() -> Vec<Piece> {
    let braking = |preset: Preset| {
        Piece::new(format!("braking lead, {}", preset.name()), move |runner| {
            let vehicle = format!("plant.vehicle=\"{}\"", preset.name());
            let driven = drive(runner, "truck-brake", Some(&vehicle))?;
            Ok(Part::of_rows(emergency(preset, &driven)))
        })
    };
    let mut pieces = vec![
        Piece::new("following figure", |runner| {
            let driven = drive(runner, "truck-follow", None)?;
            // The picture shows the drive, over distance.
            let pictures = Pictures { galleries: vec![picture(&driven)], drives: Vec::new() };
            Ok(Part { rows: points(&driven), pictures })
        }),
        Piece::new("fuel in traffic", |runner| {
            let ours = drive(runner, "truck-traffic", None)?;
            let other = drive(runner, "truck-traffic", Some("controller.name=\"acc-mpc\""))?;
            Ok(Part::of_rows(traffic(&ours, &other).into()))
        }),
    ];
    pieces.extend(Preset::ALL.map(braking));
    pieces
}

/// Drives a scenario with the law alone, and with another key.
fn drive(runner: &Runner<'_>, scenario: &str, key: Option<&str>) -> Result<Driven, Error> {
    let keys: Vec<&str> = ALONE.into_iter().chain(key).collect();
    runner.drive(scenario, &keys)
}

/// The four points of the figure.
fn points(driven: &Driven) -> Vec<Row> {
    const NOTE: &str = "driven";
    let truck = Truck::preset(Preset::Jh6At25T);
    let drag_share = mean(
        driven,
        |step| (2.0..12.0).contains(&step.time_s),
        |step| {
            let powertrain = step.powertrain?;
            let rpm = truck.engine_rpm(step.speed_mps, powertrain.gear as usize - 1);
            Some(powertrain.engine_torque_nm / truck.engine().drag_torque_nm(rpm))
        },
    );
    let at = |position_m: f64, value: &dyn Fn(&DriveStep) -> Option<f64>| {
        let mut steps = driven.drive.steps.iter().skip_while(|s| s.position_m < position_m);
        steps.find_map(value)
    };
    let relative = |step: &DriveStep| Some(step.lead_speed_mps? - step.speed_mps);
    let grown = at(1400.0, &|step| step.gap_m).zip(at(800.0, &|step| step.gap_m));
    let economic = driven.figure("economic_speed_mps");
    let excess = driven.drive.steps.iter().filter(|s| (1700.0..1900.0).contains(&s.position_m));
    let excess = excess.filter_map(|step| {
        let (_, economic) = economic.iter().rev().find(|(time_s, _)| *time_s <= step.time_s)?;
        Some(economic - step.lead_speed_mps?)
    });
    let free = mean(
        driven,
        |step| (1700.0..1900.0).contains(&step.position_m),
        |step| Some(f64::from(u8::from(step.mode? == 1))),
    );
    let small = mean(driven, after_braking(2.0, 8.0), |step| Some(-step.acceleration_mps2));
    let large = driven.drive.steps.iter().filter(|step| after_braking(12.0, 40.0)(step));
    let large = large.map(|step| -step.acceleration_mps2).fold(0.0, f64::max);
    let headway = driven.drive.steps.iter().filter_map(|step| Some(step.gap_m? / step.speed_mps));
    vec![
        Row::near("follow.0m.torque_over_drag", "", paper(1.0), drag_share, within(0.1, PLOT))
            .with_source("(1) at 0 m, downhill: the engine's torque is 0")
            .depending_on(ROAD)
            .with_note("driven; mean of 2 to 12 s, downhill behind a lead 2 m/s slower"),
        Row::near(
            "follow.0m.relative_speed_start_mps",
            "m/s",
            paper(-2.0),
            at(0.0, &relative),
            within(0.01, "the scenario begins with it"),
        )
        .with_source("(1) from -2 m/s towards 0")
        .with_note(NOTE),
        Row::near(
            "follow.400m.relative_speed_mps",
            "m/s",
            paper(0.0),
            at(400.0, &relative),
            within(0.2, PLOT),
        )
        .with_source("(2) at 400 m the relative speed stays about 0")
        .depending_on(ROAD),
        Row::at_most(
            "follow.gap_800m_less_gap_1400m",
            "m",
            paper(0.0),
            grown.map(|(late, early)| early - late),
            EXACT,
        )
        .with_note("driven; the gap grows inside its band"),
        Row::near("follow.1700m.predictive_share", "", paper(1.0), free, EXACT)
            .with_note("driven; 1700 to 1900 m, the gap is beyond d_max"),
        Row::at_most(
            "follow.1700m.speed_above_lead_mps",
            "m/s",
            paper(0.0),
            excess.reduce(f64::max),
            EXACT,
        )
        .with_note("driven; the plan's speed less the lead's, at most"),
        Row::at_most(
            "follow.2300m.first_over_largest_deceleration",
            "",
            requirement(SMALL_BEFORE_LARGE),
            small.map(|small| small / large),
            EXACT,
        )
        .with_note("driven; small while there is room, larger at the safe gap"),
        Row::near(
            "follow.end.relative_speed_mps",
            "m/s",
            paper(0.0),
            at(FIGURE_M - 1.0, &relative),
            within(0.1, PLOT),
        )
        .with_note(NOTE),
        Row::near(
            "follow.service_brake_s",
            "s",
            paper(0.0),
            driven.summary.control.figures.service_brake_s,
            EXACT,
        )
        .with_note(NOTE),
        headway_row("follow", headway.reduce(f64::min)),
    ]
}

fn after_braking(from_s: f64, to_s: f64) -> impl Fn(&DriveStep) -> bool {
    move |step| (LEAD_BRAKES_S + from_s..LEAD_BRAKES_S + to_s).contains(&step.time_s)
}

/// Fuel behind a lead whose speed goes up and down, against the following law of another paper.
fn traffic(ours: &Driven, other: &Driven) -> [Row; 2] {
    let change = fuel(ours).zip(fuel(other)).map(|(ours, other)| 100.0 * (ours / other - 1.0));
    let headway = ours.drive.steps.iter().filter_map(|step| Some(step.gap_m? / step.speed_mps));
    [
        Row::shown(
            "traffic.fuel",
            "%",
            Kind::Requirement,
            change,
            "driven; against acc-mpc behind the same lead, end energy corrected",
        ),
        headway_row("traffic", headway.reduce(f64::min)),
    ]
}

/// Fuel per distance with equal kinetic energy at both ends, L/100 km.
fn fuel(driven: &Driven) -> Option<f64> {
    let truck = Truck::preset(Preset::Jh6At49T);
    let (first, last) = (driven.drive.steps.first()?, driven.drive.steps.last()?);
    let price_gpj = controller::laws::truck::Prices::new(&truck, first.speed_mps).energy_gpj;
    let gained_j = truck.kinetic_energy_j(last.speed_mps) - truck.kinetic_energy_j(first.speed_mps);
    let grams = last.powertrain?.fuel_g - price_gpj * gained_j;
    Some(1e5 * grams / FUEL_DENSITY_GPL / last.position_m)
}

fn emergency(preset: Preset, driven: &Driven) -> Vec<Row> {
    let control = &driven.summary.control.figures;
    let collisions = f64::from(u8::from(driven.summary.outcome != Outcome::Completed));
    let name = |what: &str| format!("{}.lead_brakes_6mps2.{what}", preset.name());
    vec![
        Row::near(&name("collisions"), "", requirement(0.0), Some(collisions), EXACT)
            .with_note("driven; from 22 m/s to standstill, 1 % downhill"),
        Row::shown(&name("smallest_gap_m"), "m", Kind::Requirement, control.min_gap_m, "driven"),
        Row::shown(
            &name("service_brake_s"),
            "s",
            Kind::Requirement,
            control.service_brake_s,
            "driven; last resort",
        ),
    ]
}

fn headway_row(scenario: &str, headway_s: Option<f64>) -> Row {
    let id = format!("{scenario}.headway_below_1s");
    let short = headway_s.map(|headway_s| (MIN_HEADWAY_S - headway_s).max(0.0));
    Row::near(&id, "s", requirement(0.0), short, EXACT)
        .with_note("driven; what the shortest headway lacks of 1 s")
}

/// Mean of a value over the steps that count.
fn mean(
    driven: &Driven,
    counts: impl Fn(&DriveStep) -> bool,
    value: impl Fn(&DriveStep) -> Option<f64>,
) -> Option<f64> {
    let steps = driven.drive.steps.iter().filter(|step| counts(step));
    let values: Vec<f64> = steps.filter_map(value).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The gap and the ends of its band, by the grade of the 300 m ahead of the lead.
fn band(driven: &Driven) -> Vec<Curve> {
    let keys = GapKeys::default();
    let road = driven.scenario.road.profile().unwrap_or_default();
    let end = |value: fn(&Spacing) -> f64| {
        let road = &road;
        move |step: &DriveStep| {
            let from_m = step.position_m + step.gap_m?;
            let grade = road.mean_grade(from_m, from_m + LEAD_ROAD_M);
            Some(value(&Spacing::new(&keys, step.speed_mps, step.lead_speed_mps?, grade)))
        }
    };
    let draw = |name, tone, value: &dyn Fn(&DriveStep) -> Option<f64>| {
        Curve::new(name, tone, over_distance(driven, FIGURE_M, value))
    };
    vec![
        draw("gap", Tone::Series(0), &|step| step.gap_m),
        draw("d_max", Tone::Muted, &end(|spacing| spacing.max_m)).stroke(Stroke::Dashed),
        draw("d_min", Tone::Muted, &end(|spacing| spacing.min_m)).stroke(Stroke::Dotted),
    ]
}

fn picture(driven: &Driven) -> Gallery {
    let curve = |index, name, value: &dyn Fn(&DriveStep) -> Option<f64>| {
        Curve::new(name, Tone::Series(index), over_distance(driven, FIGURE_M, value))
    };
    let powertrain = |value: fn(&PowertrainStep) -> f64| {
        move |step: &DriveStep| step.powertrain.as_ref().map(value)
    };
    let road = Curve::new("road", Tone::Muted, height(&driven.scenario, FIGURE_M));
    let truck = curve(0, "truck", &|step| Some(3.6 * step.speed_mps));
    let ahead = curve(1, "vehicle ahead", &|step| step.lead_speed_mps.map(|v| 3.6 * v));
    let gear = curve(0, "gear", &powertrain(|p| p.gear.into())).steps();
    Gallery {
        heading: "Following".into(),
        plots: vec![
            over("Height", FIGURE_M, "m", vec![road]),
            over("Speed", FIGURE_M, "km/h", vec![truck, ahead]),
            over("Gap in its band (figure 8)", FIGURE_M, "m", band(driven)),
            over(
                "Relative speed (figure 8)",
                FIGURE_M,
                "m/s",
                vec![curve(0, "vehicle ahead less truck", &|step| {
                    Some(step.lead_speed_mps? - step.speed_mps)
                })],
            ),
            over(
                "Engine torque (figure 9)",
                FIGURE_M,
                "N m",
                vec![curve(0, "torque", &powertrain(|p| p.engine_torque_nm))],
            ),
            over("Gear, of the top six", FIGURE_M, "", vec![gear]),
            over(
                "Fuel",
                FIGURE_M,
                "L",
                vec![curve(0, "fuel", &powertrain(|p| p.fuel_g / FUEL_DENSITY_GPL))],
            ),
        ],
    }
}
