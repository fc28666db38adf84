//! Checks of a plan: that it is a road, and one that the rest of the scenario can drive on.

use messages::{TOPICS, Topic};

use crate::actor::Profile;
use crate::plan::{GeneratedPlan, Plan};
use crate::reading::refuse;
use crate::road::one_of;
use crate::schema::is_default;
use crate::{Problem, Scenario};

/// Difference of the lengths of heights and plan that counts as none, m: the step in which generated heights end.
const SAME_LENGTH_M: f64 = 5.0;
/// Distance between two places whose curvature is looked at, m.
const SPACING_M: f64 = 5.0;
/// Curvature below which a road counts as straight, 1/m.
const STRAIGHT_PERM: f64 = 1e-6;

/// Checks the plan of a scenario, and that nothing is set which acts only with a plan.
pub(super) fn check(scenario: &Scenario) -> Result<(), Problem> {
    let Some(plan) = scenario.road.plan() else { return unused(scenario) };
    let sources = [
        ("road.plan.pieces", !plan.pieces.is_empty()),
        ("road.plan.generated", plan.generated.is_some()),
        ("road.plan.opendrive", plan.opendrive.is_some()),
        ("traffic.sumo", scenario.traffic.route.is_some()),
    ];
    refuse!(if sources.iter().all(|(_, given)| !given),
        "road.plan": "this plan has no road", "`pieces`, `generated` or `opendrive`");
    one_of("plan", sources)?;
    let axis = plan.built()?;
    lanes(plan)?;
    along(plan, &axis)?;
    heights(scenario, axis.length_m())?;
    let own_road = plan.opendrive.as_ref().is_some_and(|road| !road.of_storyboard);
    refuse!(if own_road && scenario.storyboard.is_some(), "road.plan.opendrive":
        "the storyboard brings a road of its own", "a scenario without a storyboard");
    frames(scenario, &axis)?;
    reach(scenario, axis.length_m())?;
    scenario.perception.course.check()
}

/// Refuses keys that act on a road with a plan alone, where there is no plan.
fn unused(scenario: &Scenario) -> Result<(), Problem> {
    let tables = [
        ("plant.lateral", is_default(&scenario.plant.lateral)),
        ("perception.course", is_default(&scenario.perception.course)),
        ("controller.curve_speed", is_default(&scenario.controller.curve_speed)),
    ];
    super::unused(tables, "a plan of the road", "[road.plan]")?;
    let of_plan = Topic::LateralMotion as u32..=Topic::Curves as u32;
    for topic in TOPICS.into_iter().filter(|topic| of_plan.contains(&(*topic as u32))) {
        let name = topic.name();
        refuse!(if let Some(index) = super::aimed_at(scenario, topic),
            "faults.{index}.topic": "nothing is sent on `{name}` without a plan of the road",
            "[road.plan]");
    }
    Ok(())
}

/// The inner edge of a curve must lie on this side of the curve's centre.
fn lanes(plan: &Plan) -> Result<(), Problem> {
    let edges_m = [plan.lanes.left_edge_m(), -plan.lanes.right_edge_m()];
    let reach = |path: &str, inner_m: f64, radius_m: f64| {
        refuse!(if inner_m >= radius_m,
            "{path}": "the lanes reach {inner_m} m into a curve of {radius_m} m",
            "a radius above the distance of the lanes' inner edge",
            against "road.plan.lanes.width_m");
        Ok(())
    };
    if let Some(GeneratedPlan { min_radius_m, .. }) = &plan.generated {
        let inner_m = edges_m[0].max(edges_m[1]);
        reach("road.plan.generated.min_radius_m", inner_m, min_radius_m.value())?;
    }
    for (index, piece) in plan.pieces.iter().enumerate() {
        if let (Some(radius_m), Some(turn)) = (piece.radius_m, piece.turn) {
            let inner_m = edges_m[turn as usize];
            reach(&format!("road.plan.pieces.{index}"), inner_m, radius_m.value())?;
        }
    }
    Ok(())
}

/// The lines along the road are in order, and lie on this side of the centres of its curves.
fn along(plan: &Plan, axis: &road::Axis) -> Result<(), Problem> {
    const PATH: &str = "road.plan.lanes.along";
    let lines = &plan.lanes.along;
    refuse!(if !lines.is_sound(), "{PATH}": "these are not lines of lanes",
        "stations [p_m, right edge, .., left edge] in order, each from right to left");
    let path = if plan.opendrive.is_some() { "road.plan.opendrive" } else { PATH };
    for station in lines.stations() {
        let p_m = station[0];
        let curvature_perm = axis.curvature_perm(p_m);
        let radius_m = 1.0 / curvature_perm.abs();
        for edge_m in [station[1], station[station.len() - 1]] {
            let inner_m = edge_m.abs();
            refuse!(if curvature_perm * edge_m >= 1.0, "{path}":
                "at {p_m:.1} m the lanes reach {inner_m:.1} m into a curve of {radius_m:.1} m",
                "a radius above the distance of the lanes' inner edge");
        }
    }
    Ok(())
}

fn heights(scenario: &Scenario, length_m: f64) -> Result<(), Problem> {
    let end_m = scenario.road.profile()?.end_m();
    // A generated plan is longer than it was asked to be.
    let generated = scenario.road.plan().and_then(|plan| plan.generated.as_ref());
    let asked_m = generated.map_or(length_m, |generated| 1e3 * generated.length_km.value());
    let same = |length_m: f64| (end_m - length_m).abs() <= SAME_LENGTH_M;
    refuse!(if !scenario.road.is_level() && !same(length_m) && !same(asked_m), "road":
        "the heights end at {end_m} m, the plan at {length_m} m",
        "heights and a plan of the same length", against "road.plan");
    Ok(())
}

/// The on-board unit takes its approach to an intersection for a straight line.
fn frames(scenario: &Scenario, axis: &road::Axis) -> Result<(), Problem> {
    // Maps of a net have the lanes along its curves.
    let is_straight = scenario.has_obu() && scenario.traffic.route.is_none();
    let Some(last) = scenario.v2x.signals.last().filter(|_| is_straight) else {
        return Ok(());
    };
    let last_m = last.stop_line_m.value();
    let places = (0..=(last_m / SPACING_M) as usize).map(|index| index as f64 * SPACING_M);
    let bent = |place_m: f64| axis.curvature_perm(place_m).abs() > STRAIGHT_PERM;
    refuse!(if places.chain([last_m]).any(bent), "v2x.radio":
        "intersections behind or in a curve cannot come as frames",
        "v2x.radio = \"direct\", or a straight road up to the last stop line",
        against "road.plan");
    Ok(())
}

/// The value in whole tenths, rounded down: a bound that is printed so is accepted.
fn tenths(value: f64) -> f64 {
    (value * 10.0).floor() / 10.0
}

/// The road must not end before the drive, as far as that is known before it.
fn reach(scenario: &Scenario, length_m: f64) -> Result<(), Problem> {
    let end_m = tenths(length_m);
    let arrives = |who: &str, from_m: f64, speed_mps: f64, duration_s: f64| {
        let way_m = tenths(from_m + speed_mps * duration_s);
        let most_s = tenths((length_m - from_m) / speed_mps);
        refuse!(if from_m + speed_mps * duration_s > length_m, "duration_s":
            "the road ends before the drive, at {end_m} m: {who} gets to {way_m} m",
            "at most {most_s} s, or a longer road.plan", against "road.plan");
        Ok(())
    };
    for (index, signal) in scenario.v2x.signals.iter().enumerate() {
        refuse!(if signal.stop_line_m.value() > length_m, "v2x.signals.{index}.stop_line_m":
            "this stop line is behind the end of the road",
            "at most {end_m} m, or a longer road.plan", against "road.plan");
    }
    let duration_s = scenario.duration_s.value();
    for (index, actor) in scenario.actors.iter().enumerate() {
        let (start_m, is_at_start) = (actor.gap_m.value(), actor.appears_at_s.value() == 0.0);
        refuse!(if start_m + actor.length_m.value() > length_m && is_at_start,
            "actors.{index}.gap_m": "this vehicle begins behind the end of the road",
            "at most {end_m} m, or a longer road.plan", against "road.plan");
        let is_known = actor.profile == Profile::Constant && actor.events.is_empty() && is_at_start;
        if let Some(speed) = actor.initial_speed_mps.filter(|_| is_known) {
            let until_s = actor.leaves_at_s.map_or(duration_s, |leaves| leaves.value());
            let who = format!("the vehicle `{}`", actor.name.as_str());
            arrives(&who, start_m, speed.value(), until_s.min(duration_s))?;
        }
    }
    // A storyboard may end the drive before its duration.
    let is_free = scenario.actors.is_empty()
        && scenario.v2x.signals.is_empty()
        && scenario.storyboard.is_none();
    let slowest_mps = scenario.set_speed_mps.value().min(scenario.plant.initial_speed_mps.value());
    match is_free && !scenario.controller.curve_speed.enabled {
        true => arrives("the ego", 0.0, slowest_mps, duration_s),
        false => Ok(()),
    }
}
