//! Rows for conditions.

use super::Rule;

/// What storyboards wait for.
pub const CONDITIONS: &[Rule] = &[
    Rule::new("ConditionGroup", "", "Condition+", "", "holds when all its conditions do"),
    Rule::new("Condition", "name delay? conditionEdge", "", "ByEntityCondition ByValueCondition", "edges none, rising, falling, risingOrFalling; an edge needs an evaluation before it; the delay comes after the edge, s"),
    Rule::new("ByEntityCondition", "", "TriggeringEntities EntityCondition", "", "about entities"),
    Rule::new("TriggeringEntities", "triggeringEntitiesRule", "EntityRef+", "", "any or all of them"),
    Rule::new("EntityCondition", "", "", "EndOfRoadCondition CollisionCondition OffroadCondition TimeHeadwayCondition TimeToCollisionCondition AccelerationCondition StandStillCondition SpeedCondition RelativeSpeedCondition TraveledDistanceCondition ReachPositionCondition DistanceCondition RelativeDistanceCondition", "an entity that is not on the road meets none"),
    Rule::new("EndOfRoadCondition", "duration", "", "", "at the road's end for that long, s"),
    Rule::new("OffroadCondition", "duration", "", "", "origin outside all lanes for that long, s"),
    Rule::new("CollisionCondition", "", "", "EntityRef ByType", "the bounding boxes overlap"),
    Rule::new("ByType", "type", "", "", "vehicle, pedestrian or miscellaneous"),
    Rule::new("TimeHeadwayCondition", "entityRef value freespace rule alongRoute? coordinateSystem? relativeDistanceType? routingAlgorithm?", "", "", "distance over the triggering entity's speed, s; infinite at standstill"),
    Rule::new("TimeToCollisionCondition", "value freespace rule alongRoute? coordinateSystem? relativeDistanceType? routingAlgorithm?", "TimeToCollisionConditionTarget", "", "distance over closing speed, s; infinite when not closing"),
    Rule::new("TimeToCollisionConditionTarget", "", "", "EntityRef Position", "to what"),
    Rule::new("AccelerationCondition", "value rule direction?", "", "", "along the entity's heading, m/s²"),
    Rule::new("StandStillCondition", "duration", "", "", "speed 0 for that long, s"),
    Rule::new("SpeedCondition", "value rule direction?", "", "", "m/s; direction longitudinal only"),
    Rule::new("RelativeSpeedCondition", "entityRef value rule direction?", "", "", "the triggering entity's speed minus the other's, m/s"),
    Rule::new("TraveledDistanceCondition", "value", "", "", "at least that far since the start, m"),
    Rule::new("ReachPositionCondition", "tolerance", "Position", "", "origin within the tolerance, m"),
    Rule::new("DistanceCondition", "value freespace rule alongRoute? coordinateSystem? relativeDistanceType? routingAlgorithm?", "Position", "", "to a position, m"),
    Rule::new("RelativeDistanceCondition", "entityRef relativeDistanceType value freespace rule coordinateSystem? routingAlgorithm?", "", "", "longitudinal, lateral, euclidianDistance or cartesianDistance; freespace: between the boxes, 0 where they overlap"),
    Rule::new("ByValueCondition", "", "", "ParameterCondition VariableCondition SimulationTimeCondition StoryboardElementStateCondition", "about values"),
    Rule::new("ParameterCondition", "parameterRef value rule", "", "", "compared as numbers where both are numbers, as text otherwise"),
    Rule::new("VariableCondition", "variableRef value rule", "", "", "the same"),
    Rule::new("SimulationTimeCondition", "value rule", "", "", "time since the start of the run, s"),
    Rule::new("StoryboardElementStateCondition", "storyboardElementType storyboardElementRef state", "", "", "the element by name, or by path with `::`; transitions last one step"),
];
