//! Triggers and conditions, about entities and about values.

use super::along::Position;
use super::entity::EntityRef;
use super::reference::{EntityName, ParameterName, VariableName};
use super::signal::{TrafficSignalCondition, TrafficSignalControllerCondition};
use crate::declare::{
    AtLeastOne, AtLeastZero, Duration, Literal, Node, Number, OneOf, Text, Truth, Whole, elements,
    scalars, words,
};
use crate::error::ReadError;
use crate::model::Category;
use crate::model::condition::{
    self, Along, Clearance, CollisionWith, Edge, ElementKind, ElementState, EntityTest, Measured,
    Target, Test, Trigger,
};
use crate::words::Rule;

words! {
    /// Entities that a condition needs; the value is true for all of them.
    TriggeringEntitiesRule = bool { "any" false, "all" true }

    /// The axes of a distance; its value is whether the entity's own rather than the road's.
    CoordinateSystem = bool { "entity" true, "lane" false, "road" false, "trajectory" false }

    /// The direction of a speed or an acceleration.
    Direction = () { "longitudinal" () }
}

elements! { "Conditions";
    /// fires when one group holds; without groups a stop trigger never does
    StartTrigger | StopTrigger -> Trigger [] {groups: Vec<ConditionGroup>} { Ok(Trigger(groups)) }

    /// holds when all its conditions do
    ConditionGroup -> Vec<condition::Condition> [] {conditions: AtLeastOne<Condition>}
    { Ok(conditions.into_iter().flatten().collect()) }

    /// an edge needs an evaluation before it; the delay comes after the edge
    Condition -> Option<condition::Condition>
    ["name" _: ConditionName, "delay" delay_ns: Option<Duration> as "s", "conditionEdge" edge: Edge]
    {test: OneOf<(ByEntityCondition, ByValueCondition)>}
    |node| {
        if test.is_none() {
            let text = "conditions on no parameter of the file are left out (criteria for CARLA)";
            node.scene.notice(text.to_owned());
        }
        let delay_ns = delay_ns.unwrap_or(0);
        Ok(test.map(|test| condition::Condition { edge, delay_ns, test }))
    }

    /// about values
    ByValueCondition -> Option<Test> [] {
        test: OneOf<(
            ParameterCondition,
            VariableCondition,
            SimulationTimeCondition,
            StoryboardElementStateCondition,
            TrafficSignalCondition,
            TrafficSignalControllerCondition,
        )>,
    }

    /// compares numbers where both values are numbers, texts otherwise; left out with an empty reference, and as a criterion of CARLA (`criteria_...`) that no parameter has
    ParameterCondition -> Option<Test>
    ["parameterRef" of: Mentioned, "value" value: Literal, "rule" rule: Rule] {}
    { Ok(of.map(|of| Test::Value { of, rule, value })) }

    /// the same
    VariableCondition -> Option<Test>
    ["variableRef" of: VariableName, "value" value: Literal, "rule" rule: Rule] {}
    { Ok(Some(Test::Value { of, rule, value })) }

    /// time since the start of the run
    SimulationTimeCondition -> Option<Test> ["value" value: Number as "s", "rule" rule: Rule] {}
    { Ok(Some(Test::Time { rule, value })) }

    /// the element by name, or by path with `::`; transitions last one step
    StoryboardElementStateCondition -> Option<Test>
    ["storyboardElementType" kind: ElementKind, "storyboardElementRef" name: Text,
        "state" state: ElementState] {}
    |node| {
        node.scene.references.borrow_mut().push((node.place(), name.clone()));
        Ok(Some(Test::Element { kind, name, state }))
    }

    /// about entities
    ByEntityCondition -> Option<Test> []
    {triggering: TriggeringEntities, is: EntityCondition}
    {
        let (all, entities) = triggering;
        Ok(Some(Test::Entity { entities, all, is }))
    }

    /// any or all of them
    TriggeringEntities -> (bool, Vec<usize>)
    ["triggeringEntitiesRule" all: TriggeringEntitiesRule] {entities: AtLeastOne<EntityRef>}
    { Ok((all, entities.concat())) }

    /// an entity that is not on the road meets none
    EntityCondition -> EntityTest [] {
        test: OneOf<(
            EndOfRoadCondition,
            CollisionCondition,
            OffroadCondition,
            TimeHeadwayCondition,
            TimeToCollisionCondition,
            AccelerationCondition,
            StandStillCondition,
            SpeedCondition,
            RelativeSpeedCondition,
            TraveledDistanceCondition,
            ReachPositionCondition,
            DistanceCondition,
            RelativeDistanceCondition,
            RelativeClearanceCondition,
        )>,
    }

    /// at the road's end for that long
    EndOfRoadCondition -> EntityTest ["duration" duration_s: AtLeastZero as "s"] {}
    { Ok(EntityTest::EndOfRoad(duration_s)) }

    /// origin outside all lanes for that long
    OffroadCondition -> EntityTest ["duration" duration_s: AtLeastZero as "s"] {}
    { Ok(EntityTest::Offroad(duration_s)) }

    /// the bounding boxes overlap
    CollisionCondition -> EntityTest [] {with: OneOf<(Touched, ByType)>}
    { Ok(EntityTest::Collision(with)) }

    /// all entities of a kind
    ByType -> CollisionWith ["type" category: Category] {}
    { Ok(CollisionWith::Category(category)) }

    /// a reference by name
    Touched = "EntityRef" -> CollisionWith ["entityRef" entity: EntityName] {}
    { Ok(CollisionWith::Entity(entity)) }

    /// distance over the triggering entity's speed; infinite at standstill; none to what is behind it
    TimeHeadwayCondition -> EntityTest
    ["entityRef" entity: EntityName, "value" value: Number as "s", "freespace" freespace: Truth,
        "rule" rule: Rule, "alongRoute" along_route: Option<Truth>,
        "coordinateSystem" axes: Option<CoordinateSystem>,
        "relativeDistanceType" along: Option<Along>] {}
    unused ["routingAlgorithm?"]
    {
        let to = measured(Target::Entity(entity), freespace, along_route, axes, along);
        Ok(EntityTest::Headway { to, rule, value })
    }

    /// distance over closing speed; infinite when not closing
    TimeToCollisionCondition -> EntityTest
    ["value" value: Number as "s", "freespace" freespace: Truth, "rule" rule: Rule,
        "alongRoute" along_route: Option<Truth>,
        "coordinateSystem" axes: Option<CoordinateSystem>,
        "relativeDistanceType" along: Option<Along>]
    {target: TimeToCollisionConditionTarget}
    unused ["routingAlgorithm?"]
    {
        let to = measured(target, freespace, along_route, axes, along);
        Ok(EntityTest::TimeToCollision { to, rule, value })
    }

    /// to what
    TimeToCollisionConditionTarget -> Target [] {target: OneOf<(TargetEntity, TargetPosition)>}

    /// a reference by name
    TargetEntity = "EntityRef" -> Target ["entityRef" entity: EntityName] {}
    { Ok(Target::Entity(entity)) }

    /// along the entity's heading
    AccelerationCondition -> EntityTest
    ["value" value: Number as "m/s²", "rule" rule: Rule, "direction" _: Option<Direction>] {}
    { Ok(EntityTest::Acceleration { rule, value }) }

    /// speed 0 for that long
    StandStillCondition -> EntityTest ["duration" duration_s: AtLeastZero as "s"] {}
    { Ok(EntityTest::StandStill(duration_s)) }

    /// along the entity's heading
    SpeedCondition -> EntityTest
    ["value" value: Number as "m/s", "rule" rule: Rule, "direction" _: Option<Direction>] {}
    { Ok(EntityTest::Speed { rule, value }) }

    /// the triggering entity's speed minus the other's
    RelativeSpeedCondition -> EntityTest
    ["entityRef" entity: EntityName, "value" value: Number as "m/s", "rule" rule: Rule,
        "direction" _: Option<Direction>] {}
    { Ok(EntityTest::RelativeSpeed { entity, rule, value }) }

    /// at least that far since the start
    TraveledDistanceCondition -> EntityTest ["value" metres: AtLeastZero as "m"] {}
    { Ok(EntityTest::TraveledDistance(metres)) }

    /// origin within the tolerance
    ReachPositionCondition -> EntityTest ["tolerance" tolerance_m: AtLeastZero as "m"]
    {position: Position}
    { Ok(EntityTest::ReachPosition { position, tolerance_m }) }

    /// to a position
    DistanceCondition -> EntityTest
    ["value" value: Number as "m", "freespace" freespace: Truth, "rule" rule: Rule,
        "alongRoute" along_route: Option<Truth>,
        "coordinateSystem" axes: Option<CoordinateSystem>,
        "relativeDistanceType" along: Option<Along>]
    {position: Position}
    unused ["routingAlgorithm?"]
    {
        let to = measured(Target::Position(position), freespace, along_route, axes, along);
        Ok(EntityTest::Distance { to, rule, value })
    }

    /// to another entity; freespace: between the boxes, 0 where they overlap
    RelativeDistanceCondition -> EntityTest
    ["entityRef" entity: EntityName, "relativeDistanceType" along: Along,
        "value" value: Number as "m", "freespace" freespace: Truth, "rule" rule: Rule,
        "coordinateSystem" axes: Option<CoordinateSystem>] {}
    unused ["routingAlgorithm?"]
    {
        let to = measured(Target::Entity(entity), freespace, None, axes, Some(along));
        Ok(EntityTest::Distance { to, rule, value })
    }

    /// holds while these entities are not within the distances, or on other lanes than these; without a list, all entities or all lanes count
    RelativeClearanceCondition -> EntityTest
    ["oppositeLanes" opposite: Truth, "freeSpace" freespace: Truth,
        "distanceForward" ahead_m: Option<AtLeastZero> as "m",
        "distanceBackward" behind_m: Option<AtLeastZero> as "m"]
    {entities: Vec<EntityRef>, lanes: Vec<RelativeLaneRange>}
    |node| {
        let (ahead_m, behind_m) = (ahead_m.unwrap_or(0.0), behind_m.unwrap_or(0.0));
        let all = || (0..node.scene.entities.borrow().len()).collect();
        let entities = if entities.is_empty() { all() } else { entities.concat() };
        let lanes = if lanes.is_empty() { vec![(i32::MIN, i32::MAX)] } else { lanes };
        Ok(EntityTest::Clearance(Clearance { entities, lanes, ahead_m, behind_m, freespace, opposite }))
    }

    /// lanes to the left of the entity's own, from one to another; a missing end is the road's side
    RelativeLaneRange -> (i32, i32) ["from" from: Option<Whole>, "to" to: Option<Whole>] {}
    { Ok((from.unwrap_or(i32::MIN), to.unwrap_or(i32::MAX))) }
}

scalars! {
    /// The name of a condition, which is not evaluated. Files for CARLA name the criteria of its tests
    /// `criteria_...`.
    ConditionName -> (): "a text", |given| {
        given.node.scene.is_criterion.set(given.raw.text.starts_with("criteria_"));
        Ok(())
    };

    /// The name of a parameter; none if the condition is left out without it.
    Mentioned -> Option<usize>: ParameterName::kind(), |given| {
        let is_empty = given.raw.text.trim().trim_start_matches('$').is_empty();
        match ParameterName::take(given) {
            Err(_) if is_empty || given.node.scene.is_criterion.get() => Ok(None),
            found => found.map(Some),
        }
    };
}

/// The end of a distance that is a position.
struct TargetPosition;

impl crate::declare::Element for TargetPosition {
    const NAME: &'static str = Position::NAME;
    const FORM: &'static crate::declare::Form = Position::FORM;
    type Value = Target;

    fn read(node: Node<'_>) -> Result<Target, ReadError> {
        Position::read(node).map(Target::Position)
    }
}

/// The measure of a distance. A file that does not say how is measured along the entity's heading, or straight to a
/// position; version 1.0 says by `along_route` that it is along the road.
fn measured(
    target: Target,
    freespace: bool,
    along_route: Option<bool>,
    axes: Option<bool>,
    along: Option<Along>,
) -> Measured {
    let along_route = along_route == Some(true);
    let otherwise = match matches!(target, Target::Position(_)) && !along_route {
        true => Along::Euclidean,
        false => Along::Longitudinal,
    };
    let (along, entity_axes) = (along.unwrap_or(otherwise), axes.unwrap_or(!along_route));
    Measured { target, freespace, along, entity_axes }
}
