//! Lights, animations and commands of other players, which have no effect.

use super::unused::File;
use crate::declare::{OneOf, elements, unused};
use crate::model::action::Action;

elements! { "Actions";
    /// lights and animations have no effect, and the action is complete at once
    AppearanceAction -> Action [] {_: OneOf<(LightStateAction, AnimationAction)>}
    { Ok(Action::Nothing) }

    /// a command of another player has no effect, and the action is complete at once
    UserDefinedAction -> Action [] {_: CustomCommandAction}
    |node| {
        node.scene.notice(format!(
            "{}: a command of another player (`UserDefinedAction`) has no effect",
            node.place()
        ));
        Ok(Action::Nothing)
    }
}

unused! { "Read, without effect";
    CustomCommandAction ["type"] {};
    LightStateAction ["transitionTime?"] {LightType, LightState};
    LightType [] {OneOf<(VehicleLight, UserDefinedLight)>};
    VehicleLight ["vehicleLightType"] {};
    UserDefinedLight ["userDefinedLightType"] {};
    LightState ["mode" "luminousIntensity?" "flashingOnDuration?" "flashingOffDuration?"]
        {Option<Color>};
    Color ["colorType"] {Option<OneOf<(ColorRgb, ColorCmyk)>>};
    ColorRgb ["red" "green" "blue"] {};
    ColorCmyk ["cyan" "magenta" "yellow" "key"] {};
    AnimationAction ["loop?" "animationDuration?"] {AnimationType, Option<AnimationState>};
    AnimationType []
        {OneOf<(ComponentAnimation, PedestrianAnimation, AnimationFile, UserDefinedAnimation)>};
    ComponentAnimation [] {OneOf<(VehicleComponent, UserDefinedComponent)>};
    VehicleComponent ["vehicleComponentType"] {};
    UserDefinedComponent ["userDefinedComponentType"] {};
    PedestrianAnimation ["motion?" "userDefinedPedestrianAnimation?"] {Vec<PedestrianGesture>};
    PedestrianGesture ["gesture"] {};
    AnimationFile ["timeOffset?"] {File};
    UserDefinedAnimation ["userDefinedAnimationType"] {};
    AnimationState ["state"] {};
}
