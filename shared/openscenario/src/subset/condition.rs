//! Triggers and conditions.

use super::reference::{ParameterName, VariableName};
use super::signal::{TrafficSignalCondition, TrafficSignalControllerCondition};
use super::test::ByEntityCondition;
use crate::comparison::Rule;
use crate::declare::{
    AtLeastOne, Duration, Given, Later, Literal, Number, OneOf, Scalar, Text, elements, words,
};
use crate::error::ReadError;
use crate::model::condition::{self, Edge, Test, Trigger};
use crate::model::element::{ElementKind, ElementState};
use crate::scene::Reference;

/// A test; or the error that the file declares no such parameter, and whether the name is empty.
pub(super) type Meant = Result<Test, (ReadError, bool)>;

words! {
    Edge {
        "none" Edge::None,
        "rising" Edge::Rising,
        "falling" Edge::Falling,
        "risingOrFalling" Edge::RisingOrFalling,
    }

    ElementKind {
        "story" ElementKind::Story,
        "act" ElementKind::Act,
        "maneuverGroup" ElementKind::ManeuverGroup,
        "maneuver" ElementKind::Maneuver,
        "event" ElementKind::Event,
        "action" ElementKind::Action,
    }

    ElementState {
        "standbyState" ElementState::Standby,
        "runningState" ElementState::Running,
        "completeState" ElementState::Complete,
        "startTransition" ElementState::StartTransition,
        "endTransition" ElementState::EndTransition,
        "stopTransition" ElementState::StopTransition,
        "skipTransition" ElementState::SkipTransition,
    }
}

elements! { "Conditions";
    /// fires when one group holds; without groups a stop trigger never does
    StartTrigger | StopTrigger -> Trigger [] {groups: Vec<ConditionGroup>} { Ok(Trigger(groups)) }

    /// holds when all its conditions do
    ConditionGroup -> Vec<condition::Condition> [] {conditions: AtLeastOne<Condition>}
    { Ok(conditions.into_iter().flatten().collect()) }

    /// an edge needs an evaluation before it; the delay comes after the edge
    Condition -> Option<condition::Condition>
    ["name" name: Later<Text>, "delay" delay_ns: Option<Duration> as "s", "conditionEdge" edge: Edge]
    {test: OneOf<(ByEntityCondition, ByValueCondition)>}
    |node| {
        // Files for CARLA name the criteria of its tests like this. The name of a condition is not evaluated.
        let is_criterion = name.text.starts_with("criteria_");
        let test = match test {
            Ok(test) => test,
            Err((_, is_empty)) if is_empty || is_criterion => {
                let text = "conditions on no parameter of the file are left out (criteria for CARLA)";
                node.scene.notice(text.to_owned());
                return Ok(None);
            }
            Err((error, _)) => return Err(error),
        };
        let delay_ns = delay_ns.unwrap_or(0);
        Ok(Some(condition::Condition { edge, delay_ns, test }))
    }

    /// about values
    ByValueCondition -> Meant [] {
        test: OneOf<(
            ParameterCondition,
            VariableCondition,
            SimulationTimeCondition,
            StoryboardElementStateCondition,
            TrafficSignalCondition,
            TrafficSignalControllerCondition,
        )>,
    } { Ok(test) }

    /// compares numbers where both values are numbers, texts otherwise; left out with an empty reference, and as a criterion of CARLA (`criteria_...`) that no parameter has
    ParameterCondition -> Meant
    ["parameterRef" of: Mentioned, "value" value: Literal, "rule" rule: Rule] {}
    { Ok(of.map(|of| Test::Value { of, rule, value })) }

    /// the same
    VariableCondition -> Meant
    ["variableRef" of: VariableName, "value" value: Literal, "rule" rule: Rule] {}
    { Ok(Ok(Test::Value { of, rule, value })) }

    /// time since the start of the run
    SimulationTimeCondition -> Meant ["value" value: Number as "s", "rule" rule: Rule] {}
    { Ok(Ok(Test::Time { rule, value })) }

    /// the element by name, or by path with `::`; transitions last one step
    StoryboardElementStateCondition -> Meant
    ["storyboardElementType" kind: ElementKind, "storyboardElementRef" name: Text,
        "state" state: ElementState] {}
    |node| {
        let reference = Reference { place: node.place(), kind, name: name.clone() };
        node.scene.references.borrow_mut().push(reference);
        Ok(Ok(Test::Element { kind, name, state }))
    }
}

/// The name of a parameter that may not be declared.
struct Mentioned;

impl Scalar for Mentioned {
    type Value = Result<usize, (ReadError, bool)>;

    fn kind() -> String {
        ParameterName::kind()
    }

    fn take(given: &Given<'_>) -> Result<Self::Value, ReadError> {
        let is_empty = given.raw.text.trim().trim_start_matches('$').is_empty();
        Ok(ParameterName::take(given).map_err(|error| (error, is_empty)))
    }
}
