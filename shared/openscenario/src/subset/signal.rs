//! Traffic signals: their states are values that conditions compare.

use super::condition::Meant;
use crate::comparison::Rule;
use crate::declare::{Node, Text, elements};
use crate::expression::Value;
use crate::model::Named;
use crate::model::action::{Action, Change};
use crate::model::condition::Test;

elements! { "Actions";
    /// an action on traffic signals
    InfrastructureAction -> Action [] {action: TrafficSignalAction} { Ok(action) }

    /// an action on a traffic signal
    TrafficSignalAction -> Action [] {action: TrafficSignalStateAction} { Ok(action) }

    /// the state that `TrafficSignalCondition` compares; neither the ego nor others see the signal
    TrafficSignalStateAction -> Action ["name" name: Text, "state" state: Text] {}
    |node| {
        node.scene.notice(
            "traffic signals of the file change what `TrafficSignalCondition` sees; neither the ego nor others see them"
                .to_owned(),
        );
        let value = signal(node, &name);
        Ok(Action::Set { value, change: Change::To(Value::Text(state)) })
    }
}

elements! { "Conditions";
    /// the signal has this state; none does before an action sets it
    TrafficSignalCondition -> Meant ["name" name: Text, "state" state: Text] {}
    |node| {
        let of = signal(node, &name);
        Ok(Ok(Test::Value { of, rule: Rule::EqualTo, value: Value::Text(state) }))
    }
}

/// The place of a signal's state among the values of the script.
fn signal(node: Node<'_>, name: &str) -> usize {
    let name = format!("traffic signal {name}");
    let mut values = node.scene.values.borrow_mut();
    values.iter().position(|value| value.name == name).unwrap_or_else(|| {
        values.push(Named { name, value: Value::Text(String::new()) });
        values.len() - 1
    })
}
