//! The following figure, and requirements beyond it.
//!
//! The paper describes four points of its figure in words; the scenario's road and lead are laid out
//! after them. Each point is one or two rows.

use crate::row::{EXACT, Kind, Row, Tolerance, paper, requirement, within};
use crate::runner::{Driven, Part, Pictures, Piece, Runner};
use crate::trips::Trip;
use controller::laws::truck::Prices;
use scenario::Setting;
use supervise::report::Outcome;
use supervise::{DriveStep, Error};
use truck_model::{Preset, Truck};

const FIGURE_M: f64 = 3500.0;
/// Time when the lead begins to brake in the scenario, s.
const LEAD_BRAKES_S: f64 = 96.0;
/// Reason of the tolerance of what the paper shows in its figure.
const PLOT: &str = "described in words and shown in a plot without a scale";
const SPEEDS: Tolerance = within(0.1, PLOT);
/// Largest ratio of the first deceleration to the largest one that still is "small, then larger".
const SMALL_BEFORE_LARGE: f64 = 0.7;
/// Assumptions behind the rows of the figure.
const ROAD: &str = "the road and the lead of the scenario: the paper's are not printed";
const MIN_HEADWAY_S: f64 = 1.0;

/// The paper's sentences.
const FOLLOWING: &str = "the following test has a set speed of 90 km/h and a slower lead";
const DOWNHILL: &str =
    "(1) at 0 m, downhill: the engine's torque is 0, the relative speed goes from -2 m/s towards 0";
const AT_400_M: &str = "(2) at 400 m the relative speed stays about 0, the gap grows slowly";
const AT_1700_M: &str = "(3) at 1,700 m the gap is beyond d_max: the predictive cruise drives, not faster than the lead";
const AT_2300_M: &str = "(4) at 2,300 m the lead brakes: a small deceleration, a larger one at the safe gap, \
    then a smaller one until both speeds are equal";
const NO_BRAKE: &str = "it controls neither throttle nor brakes, but engine torque directly";
const SAFE: &str = "conclusion 2: following with a variable gap keeps safety and improves comfort";
const FUEL: &str = "the following considers the economic speed: less fuel than a traditional ACC";
const WARNS: &str =
    "mode 3: a gap below the least one is warned of; the driver can take over at any time";

/// The law alone: the paper's truck has no emergency brake, and its radar gives objects.
fn alone() -> Vec<Setting> {
    vec![Setting::new("perception.radar.model", "object-list"), Setting::new("aebs.enabled", false)]
}

/// The figure, the fuel in traffic, and the lead that brakes before each truck.
pub fn pieces() -> Vec<Piece> {
    let braking = |preset: Preset| {
        Piece::new(format!("braking lead, {}", preset.name()), move |runner| {
            let vehicle = Setting::new("plant.vehicle", preset.name());
            let driven = drive(runner, "truck-brake", Some(vehicle))?;
            Ok(Part::of_rows(emergency(preset, &driven).into()))
        })
    };
    let mut pieces = vec![
        Piece::new("following figure", |runner| {
            let driven = drive(runner, "truck-follow", None)?;
            let pictures = Pictures { drives: vec![driven.picture()], galleries: Vec::new() };
            Ok(Part { rows: points(&driven), pictures })
        }),
        Piece::new("fuel in traffic", |runner| {
            let ours = drive(runner, "truck-traffic", None)?;
            let other = Setting::new("controller.name", "acc-mpc");
            let other = drive(runner, "truck-traffic", Some(other))?;
            Ok(Part::of_rows(traffic(&ours, &other).into()))
        }),
    ];
    pieces.extend(Preset::ALL.map(braking));
    pieces
}

/// Drives a scenario with the law alone, and with another key.
fn drive(runner: &Runner<'_>, scenario: &str, other: Option<Setting>) -> Result<Driven, Error> {
    let set: Vec<Setting> = alone().into_iter().chain(other).collect();
    runner.drive(scenario, &set)
}

/// The four points of the figure.
fn points(driven: &Driven) -> Vec<Row> {
    let truck = Truck::preset(Preset::Jh6At25T);
    let steps = || driven.drive.steps.iter();
    let between = |from_m: f64, to_m: f64| {
        steps().filter(move |step| (from_m..to_m).contains(&step.position_m))
    };
    let downhill = steps().filter(|step| (2.0..12.0).contains(&step.time_s));
    let drag_share = mean(downhill.filter_map(|step| {
        let powertrain = step.powertrain?;
        let rpm = truck.engine_rpm(step.speed_mps, powertrain.gear as usize - 1);
        Some(powertrain.engine_torque_nm / truck.engine().drag_torque_nm(rpm))
    }));
    let at = |position_m: f64, value: &dyn Fn(&DriveStep) -> Option<f64>| {
        steps().skip_while(|step| step.position_m < position_m).find_map(value)
    };
    let relative = |step: &DriveStep| Some(step.lead_speed_mps? - step.speed_mps);
    let grown = at(1400.0, &|step| step.gap_m).zip(at(800.0, &|step| step.gap_m));
    let grown = grown.map(|(late, early)| early - late);
    let economic = driven.figure("economic_speed_mps");
    let excess = between(1700.0, 1900.0).filter_map(|step| {
        let (_, economic) = economic.iter().rev().find(|(time_s, _)| *time_s <= step.time_s)?;
        Some(economic - step.lead_speed_mps?)
    });
    let free =
        mean(between(1700.0, 1900.0).filter_map(|step| Some(f64::from(u8::from(step.mode? == 1)))));
    let braking = |from_s: f64, to_s: f64| {
        let times_s = LEAD_BRAKES_S + from_s..LEAD_BRAKES_S + to_s;
        steps()
            .filter(move |step| times_s.contains(&step.time_s))
            .map(|step| -step.acceleration_mps2)
    };
    let large = braking(12.0, 40.0).fold(0.0, f64::max);
    let small = mean(braking(2.0, 8.0)).map(|small| small / large);
    let set_kmh = Some(3.6 * driven.scenario.set_speed_mps.value());
    let braked_s = driven.summary.control.figures.service_brake_s;
    let limit = requirement(SMALL_BEFORE_LARGE);
    let end = at(FIGURE_M - 1.0, &relative);
    let rows = vec![
        Row::input("follow.set_speed_kmh", "km/h", paper(90.0), set_kmh).with_source(FOLLOWING),
        Row::near("follow.0m.torque_over_drag", "", paper(1.0), drag_share, SPEEDS)
            .with_source(DOWNHILL)
            .with_note("driven; mean of 2 to 12 s, downhill behind a lead 2 m/s slower"),
        Row::input("follow.0m.relative_speed_start_mps", "m/s", paper(-2.0), at(0.0, &relative))
            .with_source(DOWNHILL),
        Row::near(
            "follow.400m.relative_speed_mps",
            "m/s",
            paper(0.0),
            at(400.0, &relative),
            within(0.2, PLOT),
        )
        .with_source(AT_400_M),
        Row::at_most("follow.gap_800m_less_gap_1400m", "m", paper(0.0), grown, EXACT)
            .with_source(AT_400_M)
            .with_note("driven; the gap grows inside its band"),
        Row::near("follow.1700m.predictive_share", "", paper(1.0), free, EXACT)
            .with_source(AT_1700_M)
            .with_note("driven; 1700 to 1900 m, the gap is beyond d_max"),
        Row::at_most(
            "follow.1700m.speed_above_lead_mps",
            "m/s",
            paper(0.0),
            excess.reduce(f64::max),
            EXACT,
        )
        .with_source(AT_1700_M)
        .with_note("driven; the plan's speed less the lead's, at most"),
        Row::at_most("follow.2300m.first_over_largest_deceleration", "", limit, small, EXACT)
            .with_source(AT_2300_M)
            .with_note("driven; small while there is room, larger at the safe gap"),
        Row::near("follow.end.relative_speed_mps", "m/s", paper(0.0), end, SPEEDS)
            .with_source(AT_2300_M)
            .with_note("driven"),
        Row::near("follow.service_brake_s", "s", paper(0.0), braked_s, EXACT)
            .with_source(NO_BRAKE)
            .with_note("driven"),
        headway("follow", driven),
    ];
    rows.into_iter().map(|row| row.depending_on(ROAD)).collect()
}

/// Fuel behind a lead whose speed goes up and down, against the following law of another paper.
fn traffic(ours: &Driven, other: &Driven) -> [Row; 2] {
    let change = fuel(ours).zip(fuel(other)).map(|(ours, other)| 100.0 * (ours / other - 1.0));
    [
        Row::at_most("traffic.fuel", "%", paper(0.0), change, EXACT)
            .with_source(FUEL)
            .with_note("driven; against acc-mpc behind the same lead, end energy corrected"),
        headway("traffic", ours),
    ]
}

/// Fuel per distance with equal kinetic energy at both ends, L/100 km.
fn fuel(driven: &Driven) -> Option<f64> {
    let truck = Truck::preset(Preset::Jh6At49T);
    let (first, last) = (driven.drive.steps.first()?, driven.drive.steps.last()?);
    let price_gpj = Prices::new(&truck, first.speed_mps).energy_gpj;
    let gained_j = truck.kinetic_energy_j(last.speed_mps) - truck.kinetic_energy_j(first.speed_mps);
    let (length_m, fuel_g) = (last.position_m, last.powertrain?.fuel_g);
    let trip = Trip { length_m, fuel_g, gained_j, ..Trip::default() };
    Some(trip.corrected_l_per_100_km(price_gpj))
}

fn emergency(preset: Preset, driven: &Driven) -> [Row; 3] {
    let control = &driven.summary.control.figures;
    let collisions = f64::from(u8::from(driven.summary.outcome != Outcome::Completed));
    let id = |what: &str| format!("{}.lead_brakes_6mps2.{what}", preset.name());
    let shown = |what, unit, ours, note| Row::shown(&id(what), unit, Kind::Requirement, ours, note);
    [
        Row::near(&id("collisions"), "", requirement(0.0), Some(collisions), EXACT)
            .with_note("driven; from 22 m/s to standstill, 1 % downhill"),
        shown("smallest_gap_m", "m", control.min_gap_m, "driven"),
        shown("service_brake_s", "s", control.service_brake_s, "driven; last resort"),
    ]
    .map(|row| row.with_source(WARNS))
}

fn headway(scenario: &str, driven: &Driven) -> Row {
    let headway = driven.drive.steps.iter().filter_map(|step| Some(step.gap_m? / step.speed_mps));
    let short = headway.reduce(f64::min).map(|headway_s| (MIN_HEADWAY_S - headway_s).max(0.0));
    Row::near(&format!("{scenario}.headway_below_1s"), "s", requirement(0.0), short, EXACT)
        .with_source(SAFE)
        .with_note("driven; what the shortest headway lacks of 1 s")
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
