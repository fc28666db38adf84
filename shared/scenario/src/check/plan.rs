//! Checks of a plan: that it is a road, and one that the rest of the scenario can drive on.

use crate::Problem;
use crate::Scenario;
use crate::actor::Profile;
use crate::faults::{Fault, Target};
use crate::plan::{AlongRoad, GeneratedPlan, Plan, PlanPiece};
use crate::schema::is_default;
use messages::{TOPICS, Topic};

/// Difference of the lengths of heights and plan that counts as none, m: the step in which generated heights end.
const SAME_LENGTH_M: f64 = 5.0;
/// Distance between two places whose curvature is looked at, m.
const SPACING_M: f64 = 5.0;
/// Curvature below which a road counts as straight, 1/m.
const STRAIGHT_PERM: f64 = 1e-6;

/// Checks the plan of a scenario, and that nothing is set which acts only with a plan.
pub(super) fn check(scenario: &Scenario) -> Result<(), Problem> {
    let Some(plan) = scenario.road.plan() else { return unused(scenario) };
    one_source(plan)?;
    let axis = plan.built()?;
    lanes(plan)?;
    along(plan, &axis)?;
    heights(scenario, axis.length_m())?;
    let own_road = plan.opendrive.as_ref().is_some_and(|road| !road.of_storyboard);
    if own_road && scenario.storyboard.is_some() {
        return Err(Problem::new(
            "road.plan.opendrive",
            "the storyboard brings a road of its own",
            "a scenario without a storyboard",
        ));
    }
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
    if let Some((table, _)) = tables.into_iter().find(|(_, usual)| !usual) {
        let message = format!("{table} has no effect without a plan of the road");
        return Err(Problem::new(table, message, "[road.plan]"));
    }
    let of_plan = Topic::LateralMotion as u32..=Topic::Curves as u32;
    let topics = TOPICS.into_iter().filter(|topic| of_plan.contains(&(*topic as u32)));
    for topic in topics {
        let aimed = |fault: &Fault| fault.effect.target() == Target::Topic(topic);
        if let Some(index) = scenario.faults.iter().position(aimed) {
            return Err(Problem::new(
                format!("faults.{index}.topic"),
                format!("nothing is sent on `{}` without a plan of the road", topic.name()),
                "[road.plan]",
            ));
        }
    }
    Ok(())
}

fn one_source(plan: &Plan) -> Result<(), Problem> {
    let sources = [
        ("road.plan.pieces", !plan.pieces.is_empty()),
        ("road.plan.generated", plan.generated.is_some()),
        ("road.plan.opendrive", plan.opendrive.is_some()),
    ];
    let mut given = sources.into_iter().filter(|(_, given)| *given).map(|(source, _)| source);
    match (given.next(), given.next()) {
        (None, _) => Err(Problem::new(
            "road.plan",
            "this plan has no road",
            "`pieces`, `generated` or `opendrive`",
        )),
        (Some(first), Some(second)) => Err(Problem::new(
            second,
            format!("the plan is given twice, by {first} and {second}"),
            "one source for the plan",
        )
        .against(first)),
        (Some(_), None) => Ok(()),
    }
}

/// The inner edge of a curve must lie on this side of the curve's centre.
fn lanes(plan: &Plan) -> Result<(), Problem> {
    let edges_m = [plan.lanes.left_edge_m(), -plan.lanes.right_edge_m()];
    let refuse = |path: String, inner_m: f64, radius_m: f64| {
        Problem::new(
            path,
            format!("the lanes reach {inner_m} m into a curve of {radius_m} m"),
            "a radius above the distance of the lanes' inner edge",
        )
        .against("road.plan.lanes.width_m")
    };
    if let Some(GeneratedPlan { min_radius_m, .. }) = &plan.generated {
        let inner_m = edges_m[0].max(edges_m[1]);
        if inner_m >= min_radius_m.value() {
            let path = "road.plan.generated.min_radius_m".to_owned();
            return Err(refuse(path, inner_m, min_radius_m.value()));
        }
    }
    for (index, piece) in plan.pieces.iter().enumerate() {
        let PlanPiece::Arc { radius_m, turn, .. } = piece else { continue };
        let inner_m = edges_m[*turn as usize];
        if inner_m >= radius_m.value() {
            return Err(refuse(format!("road.plan.pieces.{index}"), inner_m, radius_m.value()));
        }
    }
    Ok(())
}

/// The lines along the road are in order, and lie on this side of the centres of its curves.
fn along(plan: &Plan, axis: &road::Axis) -> Result<(), Problem> {
    const PATH: &str = "road.plan.lanes.along";
    let AlongRoad(lines) = &plan.lanes.along;
    if !lines.is_sound() {
        let expected =
            "stations [p_m, right edge, .., left edge] in order, each from right to left";
        return Err(Problem::new(PATH, "these are not lines of lanes", expected));
    }
    for station in lines.stations() {
        let p_m = station[0];
        let curvature_perm = axis.curvature_perm(p_m);
        let edges = [station[1], station[station.len() - 1]];
        if let Some(edge_m) = edges.into_iter().find(|l_m| curvature_perm * l_m >= 1.0) {
            let radius_m = 1.0 / curvature_perm.abs();
            return Err(Problem::new(
                if plan.opendrive.is_some() { "road.plan.opendrive" } else { PATH },
                format!(
                    "at {p_m:.1} m the lanes reach {:.1} m into a curve of {radius_m:.1} m",
                    edge_m.abs()
                ),
                "a radius above the distance of the lanes' inner edge",
            ));
        }
    }
    Ok(())
}

fn heights(scenario: &Scenario, length_m: f64) -> Result<(), Problem> {
    let profile = scenario.road.profile()?;
    // A generated plan is longer than it was asked to be.
    let generated = scenario.road.plan().and_then(|plan| plan.generated);
    let asked_m = generated.map_or(length_m, |generated| 1e3 * generated.length_km.value());
    let same = |length_m: f64| (profile.end_m() - length_m).abs() <= SAME_LENGTH_M;
    if scenario.road.is_level() || same(length_m) || same(asked_m) {
        return Ok(());
    }
    Err(Problem::new(
        "road",
        format!("the heights end at {} m, the plan at {length_m} m", profile.end_m()),
        "heights and a plan of the same length",
    )
    .against("road.plan"))
}

/// The on-board unit takes its approach to an intersection for a straight line.
fn frames(scenario: &Scenario, axis: &road::Axis) -> Result<(), Problem> {
    let Some(last) = scenario.v2x.signals.last().filter(|_| scenario.has_obu()) else {
        return Ok(());
    };
    let last_m = last.stop_line_m.value();
    let places = (0..=(last_m / SPACING_M) as usize).map(|index| index as f64 * SPACING_M);
    let bent = |place_m: f64| axis.curvature_perm(place_m).abs() > STRAIGHT_PERM;
    match places.chain([last_m]).any(bent) {
        true => Err(Problem::new(
            "v2x.radio",
            "intersections behind or in a curve cannot come as frames",
            "v2x.radio = \"direct\", or a straight road up to the last stop line",
        )
        .against("road.plan")),
        false => Ok(()),
    }
}

/// The value in whole tenths, rounded down: a bound that is printed so is accepted.
fn tenths(value: f64) -> f64 {
    (value * 10.0).floor() / 10.0
}

/// The road must not end before the drive, as far as that is known before it.
fn reach(scenario: &Scenario, length_m: f64) -> Result<(), Problem> {
    let refuse = |path: String, what: String| {
        let expected = format!("at most {} m, or a longer road.plan", tenths(length_m));
        Err(Problem::new(path, what, expected).against("road.plan"))
    };
    let refuse_duration = |who: &str, way_m: f64, end_s: f64| {
        let what = format!(
            "the road ends before the drive, at {} m: {who} gets to {} m",
            tenths(length_m),
            tenths(way_m)
        );
        let expected = format!("at most {} s, or a longer road.plan", tenths(end_s));
        Err(Problem::new("duration_s", what, expected).against("road.plan"))
    };
    for (index, signal) in scenario.v2x.signals.iter().enumerate() {
        if signal.stop_line_m.value() > length_m {
            let what = "this stop line is behind the end of the road".to_owned();
            return refuse(format!("v2x.signals.{index}.stop_line_m"), what);
        }
    }
    let duration_s = scenario.duration_s.value();
    for (index, actor) in scenario.actors.iter().enumerate() {
        let start_m = actor.gap_m.value();
        if start_m + actor.length_m.value() > length_m && actor.appears_at_s.value() == 0.0 {
            let what = "this vehicle begins behind the end of the road".to_owned();
            return refuse(format!("actors.{index}.gap_m"), what);
        }
        let is_known = actor.profile == Profile::Constant
            && actor.events.is_empty()
            && actor.appears_at_s.value() == 0.0;
        if let Some(speed) = actor.initial_speed_mps.filter(|_| is_known) {
            let until_s = actor.leaves_at_s.map_or(duration_s, |leaves| leaves.value());
            let end_m = start_m + speed.value() * until_s.min(duration_s);
            if end_m > length_m {
                let who = format!("the vehicle `{}`", actor.name.as_str());
                return refuse_duration(&who, end_m, (length_m - start_m) / speed.value());
            }
        }
    }
    // A storyboard may end the drive before its duration.
    let is_free = scenario.actors.is_empty()
        && scenario.v2x.signals.is_empty()
        && scenario.storyboard.is_none();
    let slowest_mps = scenario.set_speed_mps.value().min(scenario.plant.initial_speed_mps.value());
    let curve_speed = scenario.controller.curve_speed.enabled;
    let way_m = slowest_mps * duration_s;
    if is_free && !curve_speed && way_m > length_m {
        return refuse_duration("the ego", way_m, length_m / slowest_mps);
    }
    Ok(())
}
