//! Triggers and conditions.

use super::reference::{ParameterName, VariableName};
use super::signal::{TrafficSignalCondition, TrafficSignalControllerCondition};
use super::test::ByEntityCondition;
use crate::comparison::Rule;
use crate::declare::{AtLeastOne, Duration, Literal, Number, OneOf, Text, elements, scalars};
use crate::model::condition::{self, Edge, Test, Trigger};
use crate::model::element::{ElementKind, ElementState};

elements! { "Conditions";
    /// fires when one group holds; without groups a stop trigger never does
    StartTrigger | StopTrigger -> Trigger [] {groups: Vec<ConditionGroup>} { Ok(Trigger(groups)) }

    /// holds when all its conditions do
    ConditionGroup -> Vec<condition::Condition> [] {conditions: AtLeastOne<Condition>}
    { Ok(conditions.into_iter().flatten().collect()) }

    /// an edge needs an evaluation before it; the delay comes after the edge
    Condition -> Option<condition::Condition>
    ["name" _: ConditionName, "delay" delay_ns: Option<Duration> as "s", "conditionEdge" edge: Edge]
    {test: OneOf<(ByEntityCondition, ByValueCondition)>}
    |node| {
        if test.is_none() {
            let text = "conditions on no parameter of the file are left out (criteria for CARLA)";
            node.scene.notice(text.to_owned());
        }
        let delay_ns = delay_ns.unwrap_or(0);
        Ok(test.map(|test| condition::Condition { edge, delay_ns, test }))
    }

    /// about values
    ByValueCondition -> Option<Test> [] {
        test: OneOf<(
            ParameterCondition,
            VariableCondition,
            SimulationTimeCondition,
            StoryboardElementStateCondition,
            TrafficSignalCondition,
            TrafficSignalControllerCondition,
        )>,
    }

    /// compares numbers where both values are numbers, texts otherwise; left out with an empty reference, and as a criterion of CARLA (`criteria_...`) that no parameter has
    ParameterCondition -> Option<Test>
    ["parameterRef" of: Mentioned, "value" value: Literal, "rule" rule: Rule] {}
    { Ok(of.map(|of| Test::Value { of, rule, value })) }

    /// the same
    VariableCondition -> Option<Test>
    ["variableRef" of: VariableName, "value" value: Literal, "rule" rule: Rule] {}
    { Ok(Some(Test::Value { of, rule, value })) }

    /// time since the start of the run
    SimulationTimeCondition -> Option<Test> ["value" value: Number as "s", "rule" rule: Rule] {}
    { Ok(Some(Test::Time { rule, value })) }

    /// the element by name, or by path with `::`; transitions last one step
    StoryboardElementStateCondition -> Option<Test>
    ["storyboardElementType" kind: ElementKind, "storyboardElementRef" name: Text,
        "state" state: ElementState] {}
    |node| {
        node.scene.references.borrow_mut().push((node.place(), name.clone()));
        Ok(Some(Test::Element { kind, name, state }))
    }
}

scalars! {
    /// The name of a condition, which is not evaluated. Files for CARLA name the criteria of its tests
    /// `criteria_...`.
    ConditionName -> (): "a text", |given| {
        given.node.scene.is_criterion.set(given.raw.text.starts_with("criteria_"));
        Ok(())
    };

    /// The name of a parameter; none if the condition is left out without it.
    Mentioned -> Option<usize>: ParameterName::kind(), |given| {
        let is_empty = given.raw.text.trim().trim_start_matches('$').is_empty();
        match ParameterName::take(given) {
            Err(_) if is_empty || given.node.scene.is_criterion.get() => Ok(None),
            found => found.map(Some),
        }
    };
}
