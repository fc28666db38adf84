//! Routes: the roads that an entity drives along, also through junctions.

use super::catalog::FromCatalog;
use super::position::Spot;
use super::unused::Properties;
use crate::declare::{AtLeastOne, Node, OneOf, Truth, elements, words};
use crate::error::ReadError;
use crate::model::action::Action;
use crate::model::position::Position;
use crate::parameter::{ParameterDeclarations, Scoped};

words! {
    /// Ways to choose a route; it leads over as few roads as possible.
    RouteStrategy = () {
        "fastest" (),
        "shortest" (),
        "leastIntersections" (),
        "leastIntersection" (),
        "random" (),
    }
}

elements! { "Actions";
    /// the entity drives along the route's roads from now on, if it is on one of them; complete at once; the ego has that of Init
    AssignRouteAction -> Action [] {way: OneOf<(Scoped<Route>, FromCatalog<Route>)>}
    |node| { driven(node, way) }

    /// the same with a route from its place in Init to this place
    AcquirePositionAction -> Action [] {at: Spot} |node| { driven(node, vec![at]) }

    /// closed="false" only
    Route -> Vec<Position> ["closed" closed: Truth] {
        _: Option<ParameterDeclarations>,
        waypoints: AtLeastOne<Waypoint>,
        _: Option<Properties>,
    } unused ["name"]
    |node| {
        if closed {
            return Err(node.wrong("closed", "closed routes are not supported", "false"));
        }
        match waypoints.as_slice() {
            [] | [_] => Err(node.refuse("a route of one waypoint", "two waypoints or more")),
            _ => Ok(waypoints),
        }
    }

    /// the route leads over its road, or the road nearest to it; its lane has no effect
    Waypoint -> Position ["routeStrategy" _: RouteStrategy] {at: Spot}
}

/// The action that a route is: in the storyboard it has its row of roads, in Init the place of its entity comes later.
fn driven(node: Node<'_>, over: Vec<Position>) -> Result<Action, ReadError> {
    let (init, actors) = (node.scene.init.borrow(), node.scene.actors.borrow());
    let placed = init.iter().find_map(|item| match item.action {
        Action::Teleport(at) if item.actor.as_ref() == actors.first() => Some(at),
        _ => None,
    });
    let start = if over.len() > 1 { over.first().copied() } else { placed };
    Ok(Action::Route(match start.filter(|_| !init.is_empty()) {
        Some(start) => vec![node.scene.on_its_way(&node.place(), start, &over)?],
        None => over,
    }))
}
