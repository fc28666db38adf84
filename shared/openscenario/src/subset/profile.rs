//! Profiles of speeds over time.

use super::reference::EntityName;
use crate::declare::{AtLeastOne, AtLeastZero, Bound, Number, Placed, elements, words};
use crate::error::ReadError;
use crate::model::action::Action;
use crate::model::timed::{Bounds, SpeedEntry, SpeedProfile};

words! {
    /// How exactly a profile is followed; the value is true where bounds come before times.
    ProfileFollowingMode = bool { "follow" true, "position" false }
}

elements! { "Actions";
    /// position: straight lines to the speeds at their times; follow: within the bounds, with an acceleration of 0 at each entry; with an entity the speeds are added to its own
    SpeedProfileAction -> Action
    ["followingMode" smooth: ProfileFollowingMode, "entityRef" relative_to: Option<EntityName>]
    {bounds: Option<DynamicConstraints>, entries: AtLeastOne<Placed<SpeedProfileEntry>>}
    {
        let backwards = entries.iter().find(|(_, entry)| relative_to.is_none() && entry.mps < 0.0);
        if let Some((place, SpeedEntry { mps, .. })) = backwards {
            let expected = "0 or more, or an `entityRef` whose speed it is added to";
            let reason = format!("the speed {mps} m/s is backwards");
            return Err(ReadError::meaning(place.clone(), reason, expected));
        }
        let entries = entries.into_iter().map(|(_, entry)| entry).collect();
        let bounds = bounds.unwrap_or(Bounds::NONE);
        Ok(Action::Profile(SpeedProfile { relative_to, smooth, bounds, entries }))
    }

    /// the time counts from the entry before; without one the speed is reached as soon as the bounds allow
    SpeedProfileEntry -> SpeedEntry
    ["speed" mps: Number as "m/s", "time" time_s: Option<AtLeastZero> as "s"] {}
    { Ok(SpeedEntry { mps, time_s }) }

    /// bounds on the way; a distance is there at once without both accelerations, and their rates have no effect on it
    DynamicConstraints -> Bounds
    ["maxAcceleration" up: Option<Bound> as "m/s²", "maxDeceleration" down: Option<Bound> as "m/s²",
        "maxAccelerationRate" up_rate: Option<Bound> as "m/s³",
        "maxDecelerationRate" down_rate: Option<Bound> as "m/s³",
        "maxSpeed" speed: Option<Bound> as "m/s"] {}
    {
        Ok(Bounds {
            acceleration_mps2: up.unwrap_or(f64::INFINITY),
            deceleration_mps2: down.unwrap_or(f64::INFINITY),
            acceleration_rate_mps3: up_rate.unwrap_or(f64::INFINITY),
            deceleration_rate_mps3: down_rate.unwrap_or(f64::INFINITY),
            speed_mps: speed.unwrap_or(f64::INFINITY),
        })
    }
}
