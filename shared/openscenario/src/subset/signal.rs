//! Traffic signals: their states are values that conditions compare.

use super::reference::{Unknown, place_of};
use crate::declare::{Duration, Node, OneOf, Text, elements, scalars};
use crate::error::ReadError;
use crate::expression::Value;
use crate::model::Named;
use crate::model::action::{Action, Change};
use crate::model::condition::Test;
use crate::model::timed::{SignalCycle, SignalPhase};
use crate::scene::Scene;
use crate::words::Rule;

elements! { "Actions";
    /// an action on traffic signals
    InfrastructureAction -> Action [] {action: TrafficSignalAction}

    /// an action on a traffic signal
    TrafficSignalAction -> Action []
    {action: OneOf<(TrafficSignalStateAction, TrafficSignalControllerAction)>}

    /// the state that `TrafficSignalCondition` compares; neither the ego nor others see the signal
    TrafficSignalStateAction -> Action ["name" name: Text, "state" state: Text] {}
    |node| {
        unseen(node);
        let value = value_of(node, &named(&name));
        Ok(Action::Set { value, change: Change::To(Value::Text(state)) })
    }

    /// the controller goes on from the beginning of the phase
    TrafficSignalControllerAction -> Action
    ["trafficSignalControllerRef" controller: ControllerName, "phase" phase: Text] {}
    |node| {
        let phase = phase_of(node, &controller, &phase)?;
        Ok(Action::Phase { controller: controller.controller, phase })
    }
}

elements! { "File";
    /// controllers of traffic signals
    TrafficSignals -> () [] {_: Vec<TrafficSignalController>}

    /// its phases come one after the other, without end; with a reference it begins the delay after that controller, which comes before it in the file
    TrafficSignalController -> ()
    ["name" name: Text, "delay" delay_ns: Option<Duration> as "s", "reference" reference: Option<Text>]
    {phases: Vec<Phase>}
    |node| {
        unseen(node);
        let scene = node.scene;
        let begins_ns = match reference.filter(|reference| !reference.is_empty()) {
            None => 0,
            Some(reference) => {
                let unknown = |Unknown(expected)| {
                    let reason = format!("there is no controller `{reference}` before this one");
                    node.wrong("reference", reason, expected)
                };
                controller_named(scene, &reference).map_err(unknown)?.begins_ns
            }
        };
        let begins_ns = begins_ns.saturating_add_unsigned(delay_ns.unwrap_or(0));
        let controller = value_of(node, &format!("traffic signal controller {name}"));
        let cycle = SignalCycle { controller, begins_ns, phases };
        if cycle.duration_ns() == 0 {
            return Err(node.refuse("a controller without a phase that lasts", "a `Phase`"));
        }
        scene.controllers.borrow_mut().push((name, cycle));
        Ok(())
    }

    /// states of signals for a time
    Phase -> SignalPhase ["name" name: Text, "duration" duration_ns: Duration as "s"]
    {states: Vec<TrafficSignalState>, _: Option<TrafficSignalGroupState>}
    { Ok(SignalPhase { name, duration_ns, states }) }

    /// the state of one signal
    TrafficSignalState -> (usize, String) ["trafficSignalId" signal: Text, "state" state: Text] {}
    |node| { Ok((value_of(node, &named(&signal)), state)) }

    /// without effect: a group has no signals of its own
    TrafficSignalGroupState -> () [] {} unused ["state"]
}

scalars! {
    ControllerName -> SignalCycle: "a controller", |given| {
        let (name, scene) = (given.text()?, given.node.scene);
        controller_named(scene, &name).map_err(|Unknown(names)| {
            let expected = match scene.controllers.borrow().is_empty() {
                true => "one in the `TrafficSignals` of the road network".to_owned(),
                false => names,
            };
            given.raw.wrong(format!("there is no controller `{name}`"), expected)
        })
    };
}

elements! { "Conditions";
    /// the signal has this state; none does before an action sets it
    TrafficSignalCondition -> Option<Test>
    ["name" name: Text, "state" state: Text] {}
    |node| {
        let of = value_of(node, &named(&name));
        Ok(Some(Test::Value { of, rule: Rule::EqualTo, value: Value::Text(state) }))
    }

    /// the controller is in this phase
    TrafficSignalControllerCondition -> Option<Test>
    ["trafficSignalControllerRef" controller: ControllerName, "phase" phase: Text] {}
    |node| {
        phase_of(node, &controller, &phase)?;
        let (of, value) = (controller.controller, Value::Text(phase));
        Ok(Some(Test::Value { of, rule: Rule::EqualTo, value }))
    }
}

/// Notes that the signals act on conditions alone.
fn unseen(node: Node<'_>) {
    node.scene.notice(
        "traffic signals of the file change what conditions see; neither the ego nor others see them"
            .to_owned(),
    );
}

fn controller_named(scene: &Scene, name: &str) -> Result<SignalCycle, Unknown> {
    let controllers = scene.controllers.borrow();
    let place = place_of(name, controllers.iter().map(|(name, _)| name.as_str()))?;
    Ok(controllers[place].1.clone())
}

fn phase_of(node: Node<'_>, controller: &SignalCycle, name: &str) -> Result<usize, ReadError> {
    place_of(name, controller.phases.iter().map(|phase| phase.name.as_str())).map_err(
        |Unknown(expected)| node.wrong("phase", format!("there is no phase `{name}`"), expected),
    )
}

/// The name of a signal's state among the values of the script.
fn named(signal: &str) -> String {
    format!("traffic signal {signal}")
}

/// The place of a text among the values of the script.
fn value_of(node: Node<'_>, name: &str) -> usize {
    let mut values = node.scene.values.borrow_mut();
    values.iter().position(|value| value.name == name).unwrap_or_else(|| {
        values.push(Named { name: name.to_owned(), value: Value::Text(String::new()) });
        values.len() - 1
    })
}
