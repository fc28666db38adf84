//! Random OpenSCENARIO files from a stream of bytes: valid ones, mostly, with extreme values.
//!
//! A mutation of single bytes rarely leaves a file readable. Here each byte chooses an action, a condition, a word or a
//! number. So nearly all files reach the moving world.

use std::fmt::Write;

/// Numbers that are likely to break arithmetic, among plain ones.
const NUMBERS: [&str; 22] = [
    "0", "1", "-1", "0.5", "2", "3.14159", "-3.14159", "10", "30", "100", "300", "-20", "1e-3",
    "1e-9", "1e-320", "1e9", "-1e9", "0.1", "5", "1e5", "-0.0", "999999",
];
const SHAPES: [&str; 4] = ["linear", "cubic", "sinusoidal", "step"];
const DIMENSIONS: [&str; 3] = ["time", "rate", "distance"];
const ENTITIES: [&str; 3] = ["Ego", "Other", "Walker"];
const TRUTHS: [&str; 2] = ["true", "false"];
const RULES: [&str; 6] =
    ["greaterThan", "lessThan", "equalTo", "greaterOrEqual", "lessOrEqual", "notEqualTo"];
const EDGES: [&str; 4] = ["none", "rising", "falling", "risingOrFalling"];
const PRIORITIES: [&str; 3] = ["overwrite", "skip", "parallel"];

/// Choices, one byte each; plain ones when the bytes are used up.
struct Choices<'a>(std::slice::Iter<'a, u8>);

impl Choices<'_> {
    fn below(&mut self, count: usize) -> usize {
        usize::from(self.0.next().copied().unwrap_or(0)) % count
    }

    fn one<'w>(&mut self, words: &[&'w str]) -> &'w str {
        words[self.below(words.len())]
    }

    fn number(&mut self) -> &'static str {
        self.one(&NUMBERS)
    }

    /// A number that is 0 or more.
    fn size(&mut self) -> &'static str {
        self.number().trim_start_matches('-')
    }

    fn position(&mut self) -> String {
        let orientation = match self.below(3) {
            0 => format!("<Orientation type=\"relative\" h=\"{}\"/>", self.number()),
            _ => String::new(),
        };
        let lane = self.one(&["-1", "-2", "1", "-3"]);
        let other = self.one(&ENTITIES);
        let (a, b) = (self.number(), self.number());
        let inside = match self.below(5) {
            0 | 1 => {
                let s = self.size();
                return format!(
                    "<Position><LanePosition roadId=\"0\" laneId=\"{lane}\" s=\"{s}\">{orientation}</LanePosition></Position>"
                );
            }
            2 => format!("<RelativeObjectPosition entityRef=\"{other}\" dx=\"{a}\" dy=\"{b}\"/>"),
            3 => format!("<RelativeRoadPosition entityRef=\"{other}\" ds=\"{a}\" dt=\"{b}\"/>"),
            _ => {
                format!("<RelativeLanePosition entityRef=\"{other}\" dLane=\"{lane}\" ds=\"{a}\"/>")
            }
        };
        format!("<Position>{inside}</Position>")
    }

    fn dynamics(&mut self, element: &str) -> String {
        let (shape, dimension, value) = (self.one(&SHAPES), self.one(&DIMENSIONS), self.size());
        format!(
            "<{element} dynamicsShape=\"{shape}\" dynamicsDimension=\"{dimension}\" value=\"{value}\"/>"
        )
    }

    fn action(&mut self) -> String {
        let other = self.one(&ENTITIES);
        let (truth, free) = (self.one(&TRUTHS), self.one(&TRUTHS));
        let inside = match self.below(10) {
            // An action that depends on its own actor is refused.
            7 => {
                let other = self.one(&["Ego", "Ego", "Ego", other]);
                self.profile(other)
            }
            8 => {
                let other = self.one(&["Ego", "Ego", "Ego", other]);
                self.meeting(other)
            }
            9 => format!(
                "<RoutingAction><AcquirePositionAction>{}</AcquirePositionAction></RoutingAction>",
                self.position()
            ),
            0 | 1 => {
                let target = match self.below(2) {
                    0 => format!("<AbsoluteTargetSpeed value=\"{}\"/>", self.size()),
                    _ => format!(
                        "<RelativeTargetSpeed entityRef=\"{other}\" value=\"{}\" speedTargetValueType=\"{}\" continuous=\"{truth}\"/>",
                        self.size(),
                        self.one(&["delta", "factor"])
                    ),
                };
                let dynamics = self.dynamics("SpeedActionDynamics");
                format!(
                    "<LongitudinalAction><SpeedAction>{dynamics}<SpeedActionTarget>{target}</SpeedActionTarget></SpeedAction></LongitudinalAction>"
                )
            }
            2 => {
                let (measure, value) = (self.one(&["distance", "timeGap"]), self.size());
                let side =
                    self.one(&["any", "trailingReferencedEntity", "leadingReferencedEntity"]);
                let bounds = match self.below(2) {
                    0 => String::new(),
                    _ => format!(
                        "<DynamicConstraints maxAcceleration=\"{}\" maxDeceleration=\"{}\" maxSpeed=\"{}\"/>",
                        self.size(),
                        self.size(),
                        self.size()
                    ),
                };
                format!(
                    "<LongitudinalAction><LongitudinalDistanceAction entityRef=\"{other}\" {measure}=\"{value}\" freespace=\"{free}\" continuous=\"{truth}\" displacement=\"{side}\">{bounds}</LongitudinalDistanceAction></LongitudinalAction>"
                )
            }
            3 => {
                let dynamics = self.dynamics("LaneChangeActionDynamics");
                let lanes = self.one(&["1", "-1", "0"]);
                format!(
                    "<LateralAction><LaneChangeAction targetLaneOffset=\"{}\">{dynamics}<LaneChangeTarget><RelativeTargetLane entityRef=\"{other}\" value=\"{lanes}\"/></LaneChangeTarget></LaneChangeAction></LateralAction>",
                    self.number()
                )
            }
            4 => {
                let most = match self.below(2) {
                    0 => String::new(),
                    _ => format!(" maxLateralAcc=\"{}\"", self.size()),
                };
                let shape = self.one(&SHAPES[1..]);
                format!(
                    "<LateralAction><LaneOffsetAction continuous=\"{truth}\"><LaneOffsetActionDynamics dynamicsShape=\"{shape}\"{most}/><LaneOffsetTarget><RelativeTargetLaneOffset entityRef=\"{other}\" value=\"{}\"/></LaneOffsetTarget></LaneOffsetAction></LateralAction>",
                    self.number()
                )
            }
            5 => format!("<TeleportAction>{}</TeleportAction>", self.position()),
            _ => self.trajectory(),
        };
        format!("<PrivateAction>{inside}</PrivateAction>")
    }

    fn bounds(&mut self) -> String {
        let names = [
            "maxAcceleration",
            "maxDeceleration",
            "maxAccelerationRate",
            "maxDecelerationRate",
            "maxSpeed",
        ];
        let mut given = String::new();
        for name in names {
            let bound = self.size();
            if self.below(2) == 0 && bound.parse() != Ok(0.0) {
                let _ = write!(given, " {name}=\"{bound}\"");
            }
        }
        format!("<DynamicConstraints{given}/>")
    }

    fn profile(&mut self, other: &str) -> String {
        let entity = match self.below(2) {
            0 => String::new(),
            _ => format!(" entityRef=\"{other}\""),
        };
        let mode = self.one(&["follow", "position"]);
        let mut inside = self.bounds();
        for _ in 0..1 + self.below(4) {
            let time = match self.below(3) {
                0 => String::new(),
                _ => format!(" time=\"{}\"", self.size()),
            };
            let speed = if entity.is_empty() { self.size() } else { self.number() };
            let _ = write!(inside, "<SpeedProfileEntry speed=\"{speed}\"{time}/>");
        }
        format!(
            "<LongitudinalAction><SpeedProfileAction followingMode=\"{mode}\"{entity}>{inside}</SpeedProfileAction></LongitudinalAction>"
        )
    }

    fn meeting(&mut self, master: &str) -> String {
        let steady = match self.below(3) {
            0 => String::new(),
            1 => format!("<TargetDistanceSteadyState distance=\"{}\"/>", self.size()),
            _ => format!("<TargetTimeSteadyState time=\"{}\"/>", self.size()),
        };
        let speed = match self.below(3) {
            0 => String::new(),
            1 => format!(
                "<FinalSpeed><AbsoluteSpeed value=\"{}\">{steady}</AbsoluteSpeed></FinalSpeed>",
                self.size()
            ),
            _ => format!(
                "<FinalSpeed><RelativeSpeedToMaster value=\"{}\" speedTargetValueType=\"{}\">{steady}</RelativeSpeedToMaster></FinalSpeed>",
                self.size(),
                self.one(&["delta", "factor"])
            ),
        };
        let (near, near_master) = (self.size(), self.size());
        let (master_goal, own_goal) = (self.position(), self.position());
        let outer = |position: String, name: &str| {
            let inside = position.trim_start_matches("<Position>").trim_end_matches("</Position>");
            format!("<{name}>{inside}</{name}>")
        };
        format!(
            "<SynchronizeAction masterEntityRef=\"{master}\" targetToleranceMaster=\"{near_master}\" targetTolerance=\"{near}\">{}{}{speed}</SynchronizeAction>",
            outer(master_goal, "TargetPositionMaster"),
            outer(own_goal, "TargetPosition")
        )
    }

    fn trajectory(&mut self) -> String {
        let (mut time_s, mut vertices) = (0.0, String::new());
        for _ in 0..2 + self.below(3) {
            time_s += self.size().parse::<f64>().expect("a number");
            let vertex = format!("<Vertex time=\"{time_s:e}\">{}</Vertex>", self.position());
            vertices.push_str(&vertex);
        }
        let timing = match self.below(2) {
            0 => "<None/>".to_owned(),
            _ => format!(
                "<Timing domainAbsoluteRelative=\"{}\" scale=\"{}\" offset=\"{}\"/>",
                self.one(&["absolute", "relative"]),
                self.size(),
                self.number()
            ),
        };
        format!(
            "<RoutingAction><FollowTrajectoryAction><TrajectoryRef><Trajectory name=\"t\" closed=\"false\"><Shape><Polyline>{vertices}</Polyline></Shape></Trajectory></TrajectoryRef><TimeReference>{timing}</TimeReference><TrajectoryFollowingMode followingMode=\"position\"/></FollowTrajectoryAction></RoutingAction>"
        )
    }

    fn trigger(&mut self) -> String {
        let (rule, value, other) = (self.one(&RULES), self.number(), self.one(&ENTITIES));
        let (free, system) = (self.one(&TRUTHS), self.one(&["road", "entity"]));
        let kind = self.one(&["longitudinal", "lateral", "euclidianDistance"]);
        let of_entity = match self.below(9) {
            8 => {
                let inside = format!("<TrafficSignalCondition name=\"7\" state=\"{value}\"/>");
                return condition(
                    self.one(&EDGES),
                    &format!("<ByValueCondition>{inside}</ByValueCondition>"),
                );
            }
            0 => {
                return condition(
                    self.one(&EDGES),
                    &format!(
                        "<ByValueCondition><SimulationTimeCondition value=\"{value}\" rule=\"{rule}\"/></ByValueCondition>"
                    ),
                );
            }
            1 => format!("<SpeedCondition value=\"{value}\" rule=\"{rule}\"/>"),
            2 => format!(
                "<RelativeSpeedCondition entityRef=\"{other}\" value=\"{value}\" rule=\"{rule}\"/>"
            ),
            3 => format!(
                "<RelativeDistanceCondition entityRef=\"{other}\" value=\"{value}\" rule=\"{rule}\" freespace=\"{free}\" relativeDistanceType=\"{kind}\" coordinateSystem=\"{system}\"/>"
            ),
            4 => format!(
                "<TimeHeadwayCondition entityRef=\"{other}\" value=\"{value}\" rule=\"{rule}\" freespace=\"{free}\" relativeDistanceType=\"{kind}\" coordinateSystem=\"{system}\"/>"
            ),
            5 => format!(
                "<TimeToCollisionCondition value=\"{value}\" rule=\"{rule}\" freespace=\"{free}\" relativeDistanceType=\"{kind}\" coordinateSystem=\"{system}\"><TimeToCollisionConditionTarget><EntityRef entityRef=\"{other}\"/></TimeToCollisionConditionTarget></TimeToCollisionCondition>"
            ),
            6 => format!("<TraveledDistanceCondition value=\"{}\"/>", self.size()),
            _ => format!("<StandStillCondition duration=\"{}\"/>", self.size()),
        };
        let who = self.one(&ENTITIES);
        condition(
            self.one(&EDGES),
            &format!(
                "<ByEntityCondition><TriggeringEntities triggeringEntitiesRule=\"any\"><EntityRef entityRef=\"{who}\"/></TriggeringEntities><EntityCondition>{of_entity}</EntityCondition></ByEntityCondition>"
            ),
        )
    }
}

fn signal(state: &str) -> String {
    format!(
        "<GlobalAction><InfrastructureAction><TrafficSignalAction><TrafficSignalStateAction name=\"7\" state=\"{state}\"/></TrafficSignalAction></InfrastructureAction></GlobalAction>"
    )
}

fn condition(edge: &str, inside: &str) -> String {
    format!(
        "<ConditionGroup><Condition name=\"c\" delay=\"0.1\" conditionEdge=\"{edge}\">{inside}</Condition></ConditionGroup>"
    )
}

fn entity(name: &str) -> String {
    format!(
        "<ScenarioObject name=\"{name}\"><Vehicle name=\"car\" vehicleCategory=\"car\"><BoundingBox><Center x=\"1.4\" y=\"0\" z=\"0.7\"/><Dimensions width=\"2\" length=\"4.5\" height=\"1.5\"/></BoundingBox></Vehicle></ScenarioObject>"
    )
}

/// The file that the bytes choose.
#[must_use]
pub fn file(bytes: &[u8]) -> String {
    let mut choose = Choices(bytes.iter());
    let mut init = String::new();
    for (name, s) in ENTITIES.iter().zip([50, 100, 150]) {
        let (speed, own) = (choose.size(), *name != "Ego");
        let _ = write!(
            init,
            "<Private entityRef=\"{name}\"><PrivateAction><TeleportAction><Position><LanePosition roadId=\"0\" laneId=\"-1\" s=\"{s}\"/></Position></TeleportAction></PrivateAction>\
             <PrivateAction><LongitudinalAction><SpeedAction><SpeedActionDynamics dynamicsShape=\"step\" dynamicsDimension=\"time\" value=\"0\"/><SpeedActionTarget><AbsoluteTargetSpeed value=\"{speed}\"/></SpeedActionTarget></SpeedAction></LongitudinalAction></PrivateAction>{}</Private>",
            if own { choose.action() } else { String::new() }
        );
    }
    let mut groups = String::new();
    for group in 0..1 + choose.below(3) {
        let (actor, count) = (choose.one(&ENTITIES[1..]), choose.one(&["1", "2", "3"]));
        let mut events = String::new();
        for event in 0..1 + choose.below(4) {
            let (priority, action, start) =
                (choose.one(&PRIORITIES), choose.action(), choose.trigger());
            let action = match choose.below(8) {
                0 => signal(choose.number()),
                _ => action,
            };
            let _ = write!(
                events,
                "<Event name=\"e{event}\" priority=\"{priority}\" maximumExecutionCount=\"{count}\"><Action name=\"a\">{action}</Action><StartTrigger>{start}</StartTrigger></Event>"
            );
        }
        let _ = write!(
            groups,
            "<ManeuverGroup maximumExecutionCount=\"{count}\" name=\"g{group}\"><Actors selectTriggeringEntities=\"false\"><EntityRef entityRef=\"{actor}\"/></Actors><Maneuver name=\"m\">{events}</Maneuver></ManeuverGroup>"
        );
    }
    let entities: String = ENTITIES.iter().map(|name| entity(name)).collect();
    format!(
        "<OpenSCENARIO><FileHeader revMajor=\"1\" revMinor=\"2\" description=\"random\"/><RoadNetwork/>\
         <Entities>{entities}</Entities><Storyboard><Init><Actions>{init}</Actions></Init>\
         <Story name=\"s\"><Act name=\"a\">{groups}</Act></Story>\
         <StopTrigger/></Storyboard></OpenSCENARIO>"
    )
}
