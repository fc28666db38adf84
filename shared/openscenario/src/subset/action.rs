//! Actions of an entity and of the world.

use super::along::Position;
use super::environment::{
    ActivateControllerAction, ControllerAction, EnvironmentAction, VisibilityAction,
};
use super::motion::{LateralAction, LongitudinalAction, SynchronizeAction};
use super::reference::{EntityName, ParameterName, VariableName};
use super::signal::InfrastructureAction;
use super::trajectory::RoutingAction;
use super::unused::AppearanceAction;
use crate::declare::{Literal, Node, Number, OneOf, elements};
use crate::error::ReadError;
use crate::model::action::{Action, Change};
use crate::model::position;

elements! { "Actions";
    /// an action of an entity
    PrivateAction -> Action [] {
        action: OneOf<(
            LongitudinalAction,
            LateralAction,
            ControllerAction,
            TeleportAction,
            RoutingAction,
            VisibilityAction,
            ActivateControllerAction,
            SynchronizeAction,
            AppearanceAction,
        )>,
    }

    /// the entity is there at once
    TeleportAction -> Action [] {position: Position}
    |node| {
        // In Init the entity may have a route.
        let is_late = !node.scene.init.borrow().is_empty();
        let there = is_late.then(|| node.scene.on_its_way(&node.place(), position, &[]));
        Ok(Action::Teleport(there.unwrap_or(Ok(position))?))
    }

    /// an action of the world
    GlobalAction -> Action []
    {
        action: OneOf<(
            EntityAction,
            ParameterAction,
            VariableAction,
            EnvironmentAction,
            InfrastructureAction,
        )>,
    }

    /// not for the ego
    EntityAction -> Action ["entityRef" entity: EntityName]
    {added: OneOf<(AddEntityAction, DeleteEntityAction)>}
    |node| {
        if entity == node.scene.ego.get() {
            return Err(node.refuse("the ego is always on the road", "another entity"));
        }
        Ok(match added {
            Some(position) => Action::Add { entity, position },
            None => Action::Delete { entity },
        })
    }

    /// the entity is on the road from now on
    AddEntityAction -> Option<position::Position> [] {position: Position}
    |node| { node.scene.on_its_way(&node.place(), position, &[]).map(Some) }

    /// the entity is gone
    DeleteEntityAction -> Option<position::Position> [] {} { Ok(None) }

    /// changes what `ParameterCondition` sees
    ParameterAction -> Action ["parameterRef" value: ParameterName]
    {change: OneOf<(SetAction, ModifyAction)>}
    |node| { set(node, value, change) }

    /// changes a variable
    VariableAction -> Action ["variableRef" value: VariableName]
    {change: OneOf<(SetAction, ModifyAction)>}
    |node| { set(node, value, change) }

    /// the new value
    SetAction -> Change ["value" value: Literal] {} { Ok(Change::To(value)) }

    /// numbers only
    ModifyAction -> Change [] {change: ModifyRule}

    /// how it is modified
    ModifyRule = "Rule" -> Change [] {change: OneOf<(AddValue, MultiplyByValue)>}

    /// added
    AddValue -> Change ["value" value: Number] {} { Ok(Change::Add(value)) }

    /// multiplied
    MultiplyByValue -> Change ["value" value: Number] {} { Ok(Change::Multiply(value)) }
}

fn set(node: Node<'_>, value: usize, change: Change) -> Result<Action, ReadError> {
    let values = node.scene.values.borrow();
    let is_number = values.get(value).is_some_and(|named| named.value.number().is_some());
    if !is_number && !matches!(change, Change::To(_)) {
        return Err(node.refuse("this value is not a number", "a number to modify"));
    }
    Ok(Action::Set { value, change })
}
