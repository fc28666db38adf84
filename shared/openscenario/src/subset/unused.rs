//! Elements that are known and have no effect.

use crate::declare::{OneOf, elements};
use crate::model::action::Action;

elements! { "Read, without effect";
    /// read, without effect; its content is not checked
    License | SceneGraphFile | Properties | Property | Performance | Axles | TrailerHitch | TrailerCoupler | TimeOfDay
        | Weather | CustomCommandAction | LightStateAction | AnimationAction -> () [] {} unused ["*"]
}

elements! { "Actions";
    /// lights and animations have no effect, and the action is complete at once
    AppearanceAction -> Action [] {_: OneOf<(LightStateAction, AnimationAction)>}
    { Ok(Action::Nothing) }

    /// a command of another player has no effect, and the action is complete at once
    UserDefinedAction -> Action [] {_: CustomCommandAction}
    |node| {
        let text = "a command of another player (`UserDefinedAction`) has no effect";
        node.scene.notice(format!("{}: {text}", node.place()));
        Ok(Action::Nothing)
    }
}
