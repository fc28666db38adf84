//! Routes: all that happens is on one road, so they lead along it.

use super::catalog::FromCatalog;
use super::position::Spot;
use super::unused::Properties;
use crate::declare::{AtLeastOne, Node, OneOf, Placed, Truth, elements, words};
use crate::error::{Place, ReadError};
use crate::model::action::Action;
use crate::model::position::{self, From};
use crate::parameter::{ParameterDeclarations, Scoped};

words! {
    /// Ways to choose a route, which do the same on one road.
    RouteStrategy = () {
        "fastest" (),
        "shortest" (),
        "leastIntersections" (),
        "leastIntersection" (),
        "random" (),
    }
}

elements! { "Actions";
    /// a route along the road is what the entity follows anyway: complete at once, without effect; a waypoint beside the road is refused
    AssignRouteAction -> Action [] {_: OneOf<(Scoped<Route>, FromCatalog<Route>)>}
    { Ok(Action::Nothing) }

    /// see `AssignRouteAction`
    AcquirePositionAction -> Action [] {at: Placed<Spot>}
    |node| {
        on_the_road(node, &at)?;
        Ok(Action::Nothing)
    }

    /// closed="false" only
    Route -> Option<(f64, f64)> ["closed" closed: Truth] {
        _: Option<ParameterDeclarations>,
        waypoints: AtLeastOne<Waypoint>,
        _: Option<Properties>,
    } unused ["name"]
    |node| {
        if closed {
            let reason = "a road that is followed once has no closed routes";
            return Err(node.wrong("closed", reason, "false"));
        }
        match waypoints.as_slice() {
            [] | [_] => Err(node.refuse("a route of one waypoint", "two waypoints or more")),
            [from_m, .., to_m] => Ok(from_m.zip(*to_m)),
        }
    }

    /// on the ego's road or the roads that continue it; its lane has no effect
    Waypoint -> Option<f64> ["routeStrategy" _: RouteStrategy] {at: Placed<Spot>}
    |node| { on_the_road(node, &at) }
}

/// Checks that a place is on the lanes of the road. Returns where along it; none for a place that is seen from an
/// entity, since that moves with it.
fn on_the_road(
    node: Node<'_>,
    (place, at): &(Place, position::Position),
) -> Result<Option<f64>, ReadError> {
    let From::Road { s_m, t_m } = at.from else { return Ok(None) };
    let scenery = node.scene.road(None)?;
    match scenery.road.holds(s_m, t_m) {
        true => Ok(Some(s_m)),
        false => {
            let reason = format!("the route leads to a place {t_m:.1} m beside the reference line");
            let expected = format!("a place on a lane of road {}", scenery.road.names());
            Err(ReadError::meaning(place.clone(), reason, expected))
        }
    }
}
