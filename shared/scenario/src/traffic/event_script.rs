//! The events of actors as a storyboard, and what is wrong with them.

use openscenario::model::action::{Action, Dimension, LaneTarget, Shape, Transition};
use openscenario::model::condition::{
    Along, Condition, Edge, ElementKind, ElementState, EntityTest, Measured, Target, Test, Trigger,
};
use openscenario::model::position::{From, Heading, Position};
use openscenario::model::storyboard::{
    Act, Event, Maneuver, ManeuverGroup, NamedAction, Priority, Story,
};
use openscenario::model::timed::SpeedTarget;
use openscenario::model::{Body, Category, Drive, Entity, InitAction};
use openscenario::road::Road;
use openscenario::{Rule, Script};

use crate::Scenario;
use crate::actor::Actor;
use crate::event::{ActorEvent, LateralChange, SpeedChange, VEHICLE_WIDTH_M, When};
use crate::name::Name;

impl Scenario {
    /// The script that moves its actors: an OpenSCENARIO file's, or one made of the actors' events.
    /// Entity 0 is the ego in the latter, entity `i + 1` the actor `i`. Nothing where no actor is
    /// moved by events.
    pub fn script(&self) -> Option<Script> {
        if let Some(storyboard) = &self.storyboard {
            return Some(storyboard.script.clone());
        }
        let moved = self.actors.iter().any(|actor| !actor.events.is_empty());
        moved.then(|| of_events(self))
    }
}

/// The events of a scenario's actors as a storyboard. Origins are at rear bumpers, `t` counts from the
/// middle of the ego's lane.
fn of_events(scenario: &Scenario) -> Script {
    let body = |length_m: f64, width_m: f64| Body {
        center_ahead_m: 0.5 * length_m,
        center_left_m: 0.0,
        length_m,
        width_m,
    };
    let ego_length_m = scenario.plant.length_m.value();
    let entity = |name: &str, body: Body, drive: Drive| Entity {
        name: name.to_owned(),
        category: Category::Vehicle,
        body,
        drive,
    };
    let ego = body(ego_length_m, VEHICLE_WIDTH_M);
    let mut entities = vec![entity("the ego", ego, Drive::External)];
    let place = |actor, s_m, t_m| InitAction {
        actor: Some(actor),
        action: Action::Teleport(Position {
            from: From::Road { row: 0, s_m, t_m },
            heading: Heading::Road(0.0),
        }),
    };
    let speed = |actor, mps| InitAction {
        actor: Some(actor),
        action: Action::Speed { target: SpeedTarget::Absolute(mps), transition: STEP },
    };
    let mut init =
        vec![place(0, -ego_length_m, 0.0), speed(0, scenario.plant.initial_speed_mps.value())];
    let mut stories = Vec::new();
    for (index, actor) in scenario.actors.iter().enumerate() {
        let moved = !actor.events.is_empty();
        let drive = if moved { Drive::Scripted } else { Drive::External };
        let body = body(actor.length_m.value(), actor.width_m.value());
        entities.push(entity(actor.name.as_str(), body, drive));
        if moved {
            init.push(place(index + 1, actor.gap_m.value(), actor.lateral_offset_m.value()));
            let initial_mps = actor.initial_speed_mps.map_or(0.0, |speed| speed.value());
            init.push(speed(index + 1, initial_mps));
            stories.push(story(scenario, index, actor));
        }
    }
    let roads = vec![Road::one_lane()];
    Script { roads, ego: 0, entities, values: Vec::new(), init, stories, stop: None }
}

const STEP: Transition = Transition { shape: Shape::Step, dimension: Dimension::Time, value: 0.0 };

fn story(scenario: &Scenario, index: usize, actor: &Actor) -> Story {
    let own = index + 1;
    let events = actor.events.iter().enumerate().map(|(number, event)| {
        let mut actions = Vec::new();
        if let Some(SpeedChange { to_mps, rate_mps2, shape }) = event.speed {
            let transition =
                Transition { shape, dimension: Dimension::Rate, value: rate_mps2.value() };
            let target = SpeedTarget::Absolute(to_mps.value());
            let action = Action::Speed { target, transition };
            actions.push(NamedAction { name: "speed".to_owned(), action });
        }
        if let Some(LateralChange { to_m, duration_s, shape }) = event.lateral {
            let transition =
                Transition { shape, dimension: Dimension::Time, value: duration_s.value() };
            let target = LaneTarget::Lateral(to_m.value());
            let action = Action::LaneChange { target, offset_m: 0.0, transition };
            actions.push(NamedAction { name: "lateral".to_owned(), action });
        }
        Event {
            name: match &event.name {
                Some(name) => name.as_str().to_owned(),
                None => format!("event {}", number + 1),
            },
            priority: Priority::Parallel,
            executions: 1,
            start: Some(Trigger(vec![vec![condition(scenario, own, event)]])),
            actions,
        }
    });
    let maneuver = Maneuver { name: "events".to_owned(), events: events.collect() };
    let group = ManeuverGroup {
        name: "actor".to_owned(),
        executions: 1,
        actors: vec![own],
        maneuvers: vec![maneuver],
    };
    let act = Act { name: "run".to_owned(), start: None, stop: None, groups: vec![group] };
    Story { name: actor.name.as_str().to_owned(), acts: vec![act] }
}

fn condition(scenario: &Scenario, own: usize, event: &ActorEvent) -> Condition {
    const BELOW: Rule = Rule::LessThan;
    const ABOVE: Rule = Rule::GreaterThan;
    let named = |name: &Name| scenario.actors.iter().position(|actor| actor.name == *name);
    let other = event.to.as_ref().and_then(named).map_or(0, |index| index + 1);
    let to = |target| Measured {
        target: Target::Entity(target),
        freespace: true,
        along: Along::Longitudinal,
        entity_axes: false,
    };
    let of = |entity, is| Test::Entity { entities: vec![entity], all: false, is };
    let gap = |rule, value| of(own, EntityTest::Distance { to: to(other), rule, value });
    // The one behind is asked: the ego, or the other actor.
    let headway = |rule, value| of(other, EntityTest::Headway { to: to(own), rule, value });
    let collision =
        |rule, value| of(other, EntityTest::TimeToCollision { to: to(own), rule, value });
    let relative = |rule, value| of(own, EntityTest::RelativeSpeed { entity: other, rule, value });
    let speed = |entity, rule, value| of(entity, EntityTest::Speed { rule, value });
    let test = match &event.when {
        When::TimeS(time) => Test::Time { rule: Rule::GreaterOrEqual, value: time.value() },
        When::GapBelowM(limit) => gap(BELOW, limit.value()),
        When::GapAboveM(limit) => gap(ABOVE, limit.value()),
        When::HeadwayBelowS(limit) => headway(BELOW, limit.value()),
        When::HeadwayAboveS(limit) => headway(ABOVE, limit.value()),
        When::TtcBelowS(limit) => collision(BELOW, limit.value()),
        When::TtcAboveS(limit) => collision(ABOVE, limit.value()),
        When::RelativeSpeedBelowMps(limit) => relative(BELOW, limit.value()),
        When::RelativeSpeedAboveMps(limit) => relative(ABOVE, limit.value()),
        When::SpeedBelowMps(limit) => speed(own, BELOW, limit.value()),
        When::SpeedAboveMps(limit) => speed(own, ABOVE, limit.value()),
        When::EgoSpeedBelowMps(limit) => speed(0, BELOW, limit.value()),
        When::EgoSpeedAboveMps(limit) => speed(0, ABOVE, limit.value()),
        When::TraveledM(way) => of(own, EntityTest::TraveledDistance(way.value())),
        When::StandsForS(time) => of(own, EntityTest::StandStill(time.value())),
        When::Completed(name) => {
            let actor = scenario.actors[own - 1].name.as_str();
            let name = format!("{actor}::run::actor::events::{}", name.as_str());
            Test::Element { kind: ElementKind::Event, name, state: ElementState::Complete }
        }
    };
    Condition { edge: Edge::None, delay_ns: event.delay_s.nanoseconds(), test }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "schema_version = 1\nname = \"x\"\n[[actors]]\nname = \"car\"\ngap_m = 60\n";

    fn read(lines: &str) -> Result<Scenario, String> {
        let text = format!("{HEAD}{lines}");
        Scenario::parse("x.toml", &text).map_err(|error| error.to_string())
    }

    const EVENTS: &str = "initial_speed_mps = 20
[[actors.events]]
name = \"a\"
when = { gap_below_m = 30 }
speed = { to_mps = 10, rate_mps2 = 2 }
[[actors.events]]
when = { completed = \"a\" }
delay_s = 2
lateral = { to_m = 3.5, duration_s = 3, shape = \"cubic\" }
";

    #[test]
    fn events_become_a_storyboard_and_read_back() {
        let scenario = read(EVENTS).expect("it is right");
        let script = scenario.script().expect("there are events");
        assert!(openscenario::World::new(script.clone()).is_ok());
        assert_eq!(script.entities.len(), 2);
        let names: Vec<&str> = script.stories[0].acts[0].groups[0].maneuvers[0]
            .events
            .iter()
            .map(|event| event.name.as_str())
            .collect();
        assert_eq!(names, ["a", "event 2"]);
        let again = Scenario::parse("again.toml", &scenario.to_toml()).expect("it was written");
        assert_eq!(again, scenario);
        assert_eq!(read("initial_speed_mps = 20\n").expect("it is right").script(), None);
    }

    #[test]
    fn every_trigger_is_read_and_makes_a_script() {
        for when in [
            "time_s = 1",
            "gap_below_m = 30",
            "gap_above_m = 30",
            "headway_below_s = 1",
            "headway_above_s = 3",
            "ttc_below_s = 2",
            "ttc_above_s = 9",
            "relative_speed_below_mps = -3.5",
            "relative_speed_above_mps = 3.5",
            "speed_below_mps = 3",
            "speed_above_mps = 30",
            "ego_speed_below_mps = 3",
            "ego_speed_above_mps = 30",
            "traveled_m = 200",
            "stands_for_s = 2",
        ] {
            let scenario = read(&EVENTS.replacen("gap_below_m = 30", when, 1)).expect(when);
            let script = scenario.script().expect("there are events");
            assert!(openscenario::World::new(script).is_ok(), "{when}");
        }
        let shown = read(&EVENTS.replacen("gap_below_m = 30", "relative_speed_below_mps = nan", 1));
        assert!(shown.expect_err("no number").contains("x.toml:9:"));
    }

    #[test]
    fn senseless_values_are_shown_at_their_line() {
        for (from, to, line, expected) in [
            ("gap_below_m = 30", "gap_under_m = 30", 9, "gap_below_m"),
            ("gap_below_m = 30", "gap_below_m = -1", 9, "a distance from 0"),
            ("speed = { to_mps = 10, rate_mps2 = 2 }", "", 7, "`speed`, `lateral` or both"),
            ("completed = \"a\"", "completed = \"b\"", 12, "expected `a`"),
            ("name = \"a\"", "name = \"a\"\nto = \"van\"", 9, "the name of another actor"),
            ("delay_s = 2", "to = \"car\"", 13, "no `to`"),
            (
                "initial_speed_mps = 20",
                "initial_speed_mps = 20\nappears_at_s = 3",
                8,
                "beside events",
            ),
            ("\"cubic\"", "\"round\"", 14, "`cubic`"),
        ] {
            assert!(EVENTS.contains(from), "{from}");
            let shown = read(&EVENTS.replacen(from, to, 1)).expect_err(to);
            assert!(
                shown.contains(&format!("x.toml:{line}:")) && shown.contains(expected),
                "{shown}"
            );
        }
        let shown =
            read("initial_speed_mps = 20\nprofile = \"storyboard\"\n").expect_err("no storyboard");
        assert!(
            shown.contains("x.toml:7:") && shown.contains("no storyboard to follow"),
            "{shown}"
        );
    }
}
