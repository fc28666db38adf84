//! Actions along the road.

use super::profile::{DynamicConstraints, SpeedProfileAction};
use super::reference::EntityName;
use crate::declare::{AtLeastZero, Node, Number, OneOf, Truth, elements, words};
use crate::error::ReadError;
use crate::model::action::{Action, Dimension, Distance, Gap, Shape, Side, Transition};
use crate::model::timed::SpeedTarget;

words! {
    /// Ways to follow that do the same.
    FollowingMode = () { "follow" (), "position" () }

    /// Meaning of a relative speed; the value is true for a factor.
    SpeedTargetValueType = bool { "delta" false, "factor" true }

    /// Coordinates that do the same along a road.
    CoordinateSystem = () { "entity" (), "lane" (), "road" () }
}

elements! { "Actions";
    /// replaces the longitudinal action that is running
    LongitudinalAction -> Action []
    {action: OneOf<(SpeedAction, LongitudinalDistanceAction, SpeedProfileAction)>}

    /// speed follows the shape to its target
    SpeedAction -> Action [] {transition: SpeedActionDynamics, target: SpeedActionTarget}
    |node| {
        let is_endless = transition.shape == Shape::Step || transition.dimension == Dimension::Rate;
        if target.is_continuous() && !is_endless {
            return Err(node.refuse(
                "a continuous target has no time or distance at which it is reached",
                "shape step or dimension rate",
            ));
        }
        Ok(Action::Speed { target, transition })
    }

    /// see "Shapes"
    SpeedActionDynamics | LaneChangeActionDynamics -> Transition
    ["dynamicsShape" shape: Shape, "dynamicsDimension" dimension: Dimension, "value" value: Number,
        "followingMode" _: Option<FollowingMode>] {}
    |node| {
        if value < 0.0 && dimension != Dimension::Rate {
            return Err(node.wrong("value", format!("{value} is negative"), "0 or more"));
        }
        Ok(Transition { shape, dimension, value: value.abs() })
    }

    /// the speed at the end
    SpeedActionTarget -> SpeedTarget []
    {target: OneOf<(AbsoluteTargetSpeed, RelativeTargetSpeed)>}

    /// a speed
    AbsoluteTargetSpeed -> SpeedTarget ["value" mps: AtLeastZero as "m/s"] {}
    { Ok(SpeedTarget::Absolute(mps)) }

    /// delta (m/s) or factor of the other's speed at the start; continuous: kept up without end
    RelativeTargetSpeed -> SpeedTarget
    ["entityRef" entity: EntityName, "value" value: Number,
        "speedTargetValueType" is_factor: SpeedTargetValueType, "continuous" continuous: Truth] {}
    |node| {
        relative(node, (entity, is_factor, value), continuous)
    }

    /// without constraints the distance is there at once; a time gap counts with the speed of the one behind; distance or timeGap, not both
    LongitudinalDistanceAction -> Action
    ["entityRef" entity: EntityName, "freespace" freespace: Truth, "continuous" continuous: Truth,
        "distance" distance: Option<AtLeastZero> as "m", "timeGap" time: Option<AtLeastZero> as "s",
        "displacement" side: Option<Side>, "coordinateSystem" _: Option<CoordinateSystem>]
    {bounds: Option<DynamicConstraints>}
    |node| {
        let gap = match (distance, time) {
            (Some(gap_m), None) => Gap::Distance(gap_m),
            (None, Some(gap_s)) => Gap::Time(gap_s),
            _ => {
                let reason = "`LongitudinalDistanceAction` has both or none of its two measures";
                return Err(node.refuse(reason, "either `distance` or `timeGap`"));
            }
        };
        let side = side.unwrap_or(Side::Behind);
        // A distance needs both accelerations.
        let limits = bounds.filter(|bounds| {
            bounds.acceleration_mps2.is_finite() && bounds.deceleration_mps2.is_finite()
        });
        Ok(Action::Distance(Distance { entity, gap, freespace, side, continuous, limits }))
    }
}

/// A speed that is a factor of another entity's, or differs from it by a value in m/s.
pub(super) fn relative(
    node: Node<'_>,
    (entity, is_factor, value): (usize, bool, f64),
    continuous: bool,
) -> Result<SpeedTarget, ReadError> {
    if is_factor && value < 0.0 {
        return Err(node.wrong("value", format!("{value} is negative"), "0 or more"));
    }
    let (factor, offset_mps) = if is_factor { (value, 0.0) } else { (1.0, value) };
    Ok(SpeedTarget::Relative { entity, factor, offset_mps, continuous })
}
