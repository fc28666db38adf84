//! Entities, their bodies, and which of them is the ego.

use super::catalog::FromCatalog;
use super::reference::EntityNames;
use super::unused::{Axles, Performance, Properties, Property, TrailerCoupler, TrailerHitch};
use crate::declare::{
    AtLeastOne, AtLeastZero, Node, Number, OneOf, Placed, Text, elements, scalars,
};
use crate::error::{Spot, meant, one_of};
use crate::model::{Body, Category, Drive, Entity, MAX_ENTITIES};
use crate::parameter::{ParameterDeclarations, Scoped};
use crate::scene::Spots;

const MAX_EXTENT_M: f64 = 100.0;

scalars! {
    Extent -> f64: format!("more than 0 and at most {MAX_EXTENT_M}; or 0 for both: unknown"),
        |given| given.number(&Self::kind(), |metres| (0.0..=MAX_EXTENT_M).contains(&metres));
}

elements! { "Entities";
    /// the ego and up to 64 others; the ego is the one of `--ego`, or is called `Ego` or else `hero`, or is the only one with a controller, or is alone
    Entities -> () []
    {objects: AtLeastOne<Placed<ScenarioObject>>, _: Vec<EntitySelection>}
    |node| {
        let mut entities = node.scene.entities.borrow_mut();
        let called = |name: &str| {
            entities.iter().position(|entity| entity.name.eq_ignore_ascii_case(name))
        };
        let controlled: Vec<usize> =
            (0..objects.len()).filter(|&entity| objects[entity].1).collect();
        let chosen = node.scene.ego_name.borrow();
        let named = match &*chosen {
            None => called("ego").or_else(|| called("hero")),
            Some(name) => {
                let position = entities.iter().position(|entity| entity.name == *name);
                Some(position.ok_or_else(|| {
                    let names = entities.iter().map(|entity| entity.name.as_str());
                    node.refuse(format!("`--ego {name}` names no entity"), meant(name, names))
                })?)
            }
        };
        let ego = match (named, controlled.as_slice()) {
            (Some(named), _) => named,
            (None, [only]) => *only,
            (None, []) if entities.len() == 1 => 0,
            (None, _) => {
                let names = one_of(entities.iter().map(|entity| entity.name.as_str()));
                let others = "an entity called `Ego` or `hero`, or exactly one with an `ObjectController`";
                let expected = format!("`--ego NAME` with {names}, {others}");
                return Err(node.refuse("no entity is known to be the ego", expected));
            }
        };
        entities[ego].drive = Drive::External;
        node.scene.ego.set(ego);
        if controlled.iter().any(|entity| *entity != ego) {
            let text = "controllers of entities other than the ego have no effect";
            node.scene.notice(text.to_owned());
        }
        let spots: Vec<Spot> = objects.into_iter().map(|(place, _)| place.spot).collect();
        let starts = spots.clone();
        node.scene.spots.replace(Spots { entities: spots, starts, stop: None });
        Ok(())
    }

    /// an entity; the ego is driven by timegap's stack, the others by the storyboard
    ScenarioObject -> bool ["name" name: Text] {
        (category, body): OneOf<(
            FromCatalog<OneOf<(Vehicle, Pedestrian, MiscObject)>>,
            Scoped<Vehicle>,
            Scoped<Pedestrian>,
            Scoped<MiscObject>,
        )>,
        controllers: Vec<ObjectController>,
    } |node| {
        let mut entities = node.scene.entities.borrow_mut();
        if entities.iter().any(|entity| entity.name == name) {
            let reason = format!("`{name}` is there twice");
            return Err(node.wrong("name", reason, "a name of its own"));
        }
        if entities.len() == MAX_ENTITIES {
            return Err(node.refuse("too many entities", format!("at most {MAX_ENTITIES}")));
        }
        entities.push(Entity { name, category, body, drive: Drive::Scripted });
        Ok(controllers.contains(&true))
    }

    /// a name for several entities, for `Actors` and `TriggeringEntities`
    EntitySelection -> () ["name" name: Text] {members: Members}
    |node| {
        node.scene.selections.borrow_mut().push((name, members));
        Ok(())
    }

    /// the entities of a selection
    Members -> Vec<usize> [] {members: AtLeastOne<EntityRef>} { Ok(members.concat()) }

    /// a reference by name
    EntityRef -> Vec<usize> ["entityRef" entities: EntityNames] {}

    /// marks the ego, unless it is empty
    ObjectController -> bool [] {
        entry: Option<FromCatalog<Controller>>,
        own: Option<Controller>,
    } unused ["name?"] { Ok(entry.or(own).unwrap_or(false)) }

    /// read, without effect beside `ObjectController`
    Controller -> bool [] {_: Option<ParameterDeclarations>, _: Option<Properties>}
    unused ["name" "controllerType?"] { Ok(true) }

    /// its bounding box; a mass has no effect
    Vehicle -> (Category, Body) [] {
        _: Option<ParameterDeclarations>,
        body: BoundingBox,
        _: Option<Performance>,
        _: Option<Axles>,
        _: Option<TrailerHitch>,
        _: Option<TrailerCoupler>,
        _: Option<Trailer>,
        _: Option<Properties>,
        _: Vec<Property>,
    } unused ["name" "vehicleCategory" "role?" "mass?" "model3d?"]
    |node| { Ok((Category::Vehicle, sized(node, body, 4.5, 1.8))) }

    /// no trailer is pulled: with an empty reference only
    Trailer -> () [] {_: TrailerRef}

    /// see `Trailer`
    TrailerRef -> () ["entityRef" name: Text] {}
    |node| {
        if !name.is_empty() {
            let reason = format!("`{name}` would be pulled as a trailer");
            return Err(node.wrong("entityRef", reason, "none (an empty reference)"));
        }
        Ok(())
    }

    /// its bounding box
    Pedestrian -> (Category, Body) []
    {_: Option<ParameterDeclarations>, body: BoundingBox, _: Option<Properties>}
    unused ["name" "pedestrianCategory" "mass?" "model?" "model3d?" "role?"]
    |node| { Ok((Category::Pedestrian, sized(node, body, 0.5, 0.5))) }

    /// its bounding box
    MiscObject -> (Category, Body) []
    {_: Option<ParameterDeclarations>, body: BoundingBox, _: Option<Properties>}
    unused ["name" "miscObjectCategory" "mass?" "model3d?"]
    |node| { Ok((Category::MiscObject, sized(node, body, 1.0, 1.0))) }

    /// extent of the body, for gaps, contact and the radar
    BoundingBox -> Body [] {center: Center, dimensions: Dimensions}
    {
        let ((center_ahead_m, center_left_m), (length_m, width_m)) = (center, dimensions);
        Ok(Body { center_ahead_m, center_left_m, length_m, width_m })
    }

    /// centre of the box, seen from the entity's origin
    Center -> (f64, f64) ["x" ahead_m: Number as "m", "y" left_m: Number as "m"] {} unused ["z"]
    { Ok((ahead_m, left_m)) }

    /// size of the box
    Dimensions -> (f64, f64)
    ["width" width_m: Extent as "m", "length" length_m: Extent as "m", "height" _: AtLeastZero as "m"]
    {}
    |node| {
        match (length_m == 0.0, width_m == 0.0) {
            (true, false) => Err(node.wrong("length", "0 is out of range", "more than 0")),
            (false, true) => Err(node.wrong("width", "0 is out of range", "more than 0")),
            _ => Ok((length_m, width_m)),
        }
    }
}

/// The body of a catalog's entry or of an entity. Files for players with models of their own leave the size away.
pub(super) fn sized(node: Node<'_>, body: Body, length_m: f64, width_m: f64) -> Body {
    if body.length_m > 0.0 {
        return body;
    }
    node.scene.notice(format!(
        "{}: the bounding box has no size: {length_m} m by {width_m} m is assumed",
        node.place()
    ));
    Body { length_m, width_m, ..body }
}
