//! Actions of the environment and of controllers, which have no effect.

use super::catalog::FromCatalog;
use super::entity::{Controller, ObjectController};
use super::unused::{Properties, TimeOfDay, Weather};
use crate::declare::{OneOf, Positive, Truth, elements};
use crate::model::action::Action;
use crate::parameter::{ParameterDeclarations, Scoped};

elements! { "Actions";
    /// weather and time of day have no effect, and the action is complete at once; the friction is that of Init
    EnvironmentAction -> Action [] {friction: OneOf<(Scoped<Environment>, FromCatalog<Environment>)>}
    |node| {
        let scene = node.scene;
        // The actions of Init are listed once all of them have been read. The ego's place is one.
        if scene.init.borrow().is_empty() {
            scene.friction.set(friction.or(scene.friction.get()));
        } else if friction.is_some_and(|factor| factor != scene.friction.get().unwrap_or(1.0)) {
            let reason = "the friction of the road would change during the drive";
            return Err(node.refuse(reason, "the friction of Init"));
        }
        Ok(Action::Nothing)
    }

    /// see `EnvironmentAction`
    Environment -> Option<f64> [] {
        _: Option<ParameterDeclarations>,
        _: Option<TimeOfDay>,
        _: Option<Weather>,
        friction: Option<RoadCondition>,
    } unused ["name"]

    /// in Init the factor of the ego's strongest deceleration; other entities do not slip
    RoadCondition -> f64 ["frictionScaleFactor" factor: Positive] {_: Option<Properties>}
    unused ["wetness?"]

    /// the ego's stack drives from the start: assigned and activated controllers change nothing, and the action is complete at once
    ControllerAction -> Action [] {
        assigned: Option<AssignControllerAction>,
        overridden: Option<OverrideControllerValueAction>,
        activated: Option<ActivateControllerAction>,
    } |node| {
        if assigned.is_none() && overridden.is_none() && activated.is_none() {
            return Err(node.refuse(
                "`ControllerAction` is empty",
                "`AssignControllerAction` or `ActivateControllerAction`",
            ));
        }
        Ok(Action::Nothing)
    }

    /// see `ControllerAction`
    AssignControllerAction -> () []
    {_: OneOf<(Controller, ObjectController, FromCatalog<Controller>)>}
    unused ["activateLateral?" "activateLongitudinal?" "activateAnimation?" "activateLighting?"]

    /// overrides nothing: active="false" only
    OverrideControllerValueAction -> () [] {
        _: Option<Throttle>,
        _: Option<Brake>,
        _: Option<Clutch>,
        _: Option<ParkingBrake>,
        _: Option<SteeringWheel>,
        _: Option<Gear>,
    }

    /// see `OverrideControllerValueAction`
    Throttle | Brake | Clutch | ParkingBrake | SteeringWheel | Gear -> () ["active" active: Truth] {}
    unused ["value?" "maxRate?" "number?"]
    |node| {
        if active {
            let reason = format!("`{}` would be overridden", node.name());
            return Err(node.wrong("active", reason, "false"));
        }
        Ok(())
    }

    /// see `ControllerAction`
    ActivateControllerAction -> Action [] {}
    unused ["lateral?" "longitudinal?" "animation?" "lighting?" "controllerRef?" "objectControllerRef?"]
    { Ok(Action::Nothing) }

    /// complete at once, without effect
    VisibilityAction -> Action [] {} unused ["graphics" "sensors" "traffic"]
    { Ok(Action::Nothing) }
}
