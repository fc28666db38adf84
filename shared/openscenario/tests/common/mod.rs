//! Small scenarios in memory.

#![allow(
    clippy::result_large_err,
    reason = "an error ends the reading of a file; its size costs nothing"
)]
#![allow(dead_code)]

pub mod crossing;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use openscenario::read::{self, Scenario};
use openscenario::{Assignment, Choices, LaneHeadings, Motion, ReadError, Source, World};

/// Period of the steps, s.
pub const STEP_S: f64 = 0.01;

/// A straight road of 1000 m with the lanes -2, -1, 1, each 4 m wide.
pub const ROAD: &str = r#"<OpenDRIVE><road id="0" length="1000"><planView><geometry s="0" x="0" y="0" hdg="0" length="1000"><line/></geometry></planView>
<lanes><laneSection s="0">
<left><lane id="1"><width sOffset="0" a="4" b="0" c="0" d="0"/></lane></left><center><lane id="0"/></center>
<right><lane id="-1"><width sOffset="0" a="4" b="0" c="0" d="0"/></lane><lane id="-2"><width sOffset="0" a="4" b="0" c="0" d="0"/></lane></right>
</laneSection></lanes></road></OpenDRIVE>"#;

/// Files in memory.
pub struct Files(pub BTreeMap<PathBuf, String>);

impl Source for Files {
    fn read(&self, path: &Path) -> std::io::Result<String> {
        self.0.get(path).cloned().ok_or_else(|| std::io::ErrorKind::NotFound.into())
    }

    fn list(&self, directory: &Path) -> std::io::Result<Vec<PathBuf>> {
        let inside = self.0.keys().filter(|path| path.parent() == Some(directory));
        let files: Vec<PathBuf> = inside.cloned().collect();
        if files.is_empty() { Err(std::io::ErrorKind::NotFound.into()) } else { Ok(files) }
    }
}

/// The reference to the road file.
const LOGIC: &str = "<LogicFile filepath=\"road.xodr\"/>";

/// The parts of a scenario file.
#[derive(Clone, Default)]
pub struct Parts {
    pub parameters: String,
    pub head: String,
    pub init: String,
    pub stories: String,
    pub stop: String,
    pub files: Vec<(String, String)>,
    pub assigned: Vec<(String, String)>,
    pub headings: Option<LaneHeadings>,
    pub ego: Option<String>,
    /// The content of the road network; the road file alone where it is empty.
    pub network: String,
}

impl Parts {
    pub fn text(&self) -> String {
        let box_of = |length: f64, width: f64| {
            format!(
                "<BoundingBox><Center x=\"1\" y=\"0\" z=\"1\"/><Dimensions width=\"{width}\" length=\"{length}\" height=\"1.5\"/></BoundingBox>"
            )
        };
        let car = |name: &str| {
            format!(
                "<ScenarioObject name=\"{name}\"><Vehicle name=\"car\" vehicleCategory=\"car\">{}</Vehicle></ScenarioObject>",
                box_of(4.0, 2.0)
            )
        };
        let walker = format!(
            "<ScenarioObject name=\"Walker\"><Pedestrian name=\"p\" pedestrianCategory=\"pedestrian\">{}</Pedestrian></ScenarioObject>",
            box_of(0.4, 0.6)
        );
        format!(
            "<OpenSCENARIO>\n<FileHeader revMajor=\"1\" revMinor=\"2\" description=\"a test\"/>\n{}{}\
             <RoadNetwork>{}</RoadNetwork>\n\
             <Entities>{}{}{walker}</Entities>\n\
             <Storyboard><Init><Actions>{}{}</Actions></Init>\n{}\n<StopTrigger>{}</StopTrigger></Storyboard></OpenSCENARIO>",
            self.parameters,
            self.head,
            if self.network.is_empty() { LOGIC } else { &self.network },
            car("Ego"),
            car("Lead"),
            private("Ego", &[&place(-1, 10.0), &speed("step", "time", 0.0, 20.0)]),
            if self.init.is_empty() {
                private("Lead", &[&place(-1, 60.0), &speed("step", "time", 0.0, 20.0)])
            } else {
                self.init.clone()
            },
            self.stories,
            self.stop
        )
    }

    pub fn read(&self) -> Result<Scenario, ReadError> {
        let mut files: BTreeMap<PathBuf, String> =
            self.files.iter().map(|(path, text)| (path.into(), text.clone())).collect();
        files.insert("dir/a.xosc".into(), self.text());
        files.entry("dir/road.xodr".into()).or_insert_with(|| ROAD.to_owned());
        let assigned: Vec<Assignment> = self
            .assigned
            .iter()
            .map(|(name, value)| Assignment { name: name.clone(), value: value.clone() })
            .collect();
        let choices = Choices { assigned, headings: self.headings, ego: self.ego.clone() };
        read::scenario(Path::new("dir/a.xosc"), &Files(files), &choices)
    }

    pub fn run(&self) -> Run {
        let read = self.read().unwrap_or_else(|error| panic!("{error}"));
        Run::of(World::new(read.script).unwrap_or_else(|error| panic!("{error}")))
    }

    pub fn refusal(&self) -> String {
        self.read().expect_err("it is wrong").to_string()
    }
}

/// A world with an ego that keeps its speed.
pub struct Run {
    pub world: World,
    pub ego: Motion,
    ticks: u64,
}

impl Run {
    pub fn of(world: World) -> Self {
        let ego = world.motion(world.script().ego);
        Self { world, ego, ticks: 0 }
    }

    pub fn to(&mut self, time_s: f64) -> &mut Self {
        let end = (time_s / STEP_S).round() as u64;
        while self.ticks <= end {
            let start = self.world.script().ego;
            self.world.observe(start, self.ego);
            self.world.step(self.ticks * 10_000_000);
            self.ego.s_m += self.ego.speed_mps * STEP_S;
            self.ticks += 1;
        }
        self
    }

    pub fn of_entity(&self, name: &str) -> Motion {
        self.world.motion(self.world.script().entity(name).expect("it is there"))
    }

    pub fn lead(&self) -> Motion {
        self.of_entity("Lead")
    }
}

pub fn private(entity: &str, actions: &[&str]) -> String {
    let actions: String =
        actions.iter().map(|a| format!("<PrivateAction>{a}</PrivateAction>")).collect();
    format!("<Private entityRef=\"{entity}\">{actions}</Private>")
}

pub fn place(lane: i32, s_m: f64) -> String {
    teleport(&format!("<LanePosition roadId=\"0\" laneId=\"{lane}\" s=\"{s_m}\"/>"))
}

pub fn teleport(position: &str) -> String {
    format!("<TeleportAction><Position>{position}</Position></TeleportAction>")
}

pub fn speed(shape: &str, dimension: &str, value: f64, target: f64) -> String {
    speed_to(shape, dimension, value, &format!("<AbsoluteTargetSpeed value=\"{target}\"/>"))
}

pub fn speed_to(shape: &str, dimension: &str, value: f64, target: &str) -> String {
    format!(
        "<LongitudinalAction><SpeedAction><SpeedActionDynamics dynamicsShape=\"{shape}\" dynamicsDimension=\"{dimension}\" value=\"{value}\"/>\
         <SpeedActionTarget>{target}</SpeedActionTarget></SpeedAction></LongitudinalAction>"
    )
}

pub fn lane_change(shape: &str, dimension: &str, value: f64, target: &str) -> String {
    format!(
        "<LateralAction><LaneChangeAction><LaneChangeActionDynamics dynamicsShape=\"{shape}\" dynamicsDimension=\"{dimension}\" value=\"{value}\"/>\
         <LaneChangeTarget>{target}</LaneChangeTarget></LaneChangeAction></LateralAction>"
    )
}

/// A story of one maneuver of `Lead`.
pub fn story(events: &[String]) -> String {
    story_of("Lead", "Story", 1, events)
}

pub fn story_of(actor: &str, name: &str, executions: u32, events: &[String]) -> String {
    format!(
        "<Story name=\"{name}\"><Act name=\"Act\"><ManeuverGroup maximumExecutionCount=\"{executions}\" name=\"Group\">\
         <Actors selectTriggeringEntities=\"false\"><EntityRef entityRef=\"{actor}\"/></Actors>\
         <Maneuver name=\"Maneuver\">{}</Maneuver></ManeuverGroup>\
         <StartTrigger>{}</StartTrigger></Act></Story>",
        events.concat(),
        trigger(&[&at(0.0)])
    )
}

pub fn event(name: &str, priority: &str, actions: &[&str], start: &str) -> String {
    let actions: String = actions
        .iter()
        .enumerate()
        .map(|(i, action)| {
            format!(
                "<Action name=\"{name}Action{i}\"><PrivateAction>{action}</PrivateAction></Action>"
            )
        })
        .collect();
    format!(
        "<Event name=\"{name}\" priority=\"{priority}\">{actions}<StartTrigger>{start}</StartTrigger></Event>"
    )
}

/// Holds when all conditions do.
pub fn trigger(conditions: &[&str]) -> String {
    format!("<ConditionGroup>{}</ConditionGroup>", conditions.concat())
}

pub fn condition(edge: &str, delay: f64, inside: &str) -> String {
    format!("<Condition name=\"c\" delay=\"{delay}\" conditionEdge=\"{edge}\">{inside}</Condition>")
}

pub fn at(time_s: f64) -> String {
    condition(
        "none",
        0.0,
        &format!(
            "<ByValueCondition><SimulationTimeCondition value=\"{time_s}\" rule=\"greaterOrEqual\"/></ByValueCondition>"
        ),
    )
}

pub fn by_entity(edge: &str, delay: f64, entity: &str, inside: &str) -> String {
    condition(
        edge,
        delay,
        &format!(
            "<ByEntityCondition><TriggeringEntities triggeringEntitiesRule=\"any\"><EntityRef entityRef=\"{entity}\"/></TriggeringEntities>\
             <EntityCondition>{inside}</EntityCondition></ByEntityCondition>"
        ),
    )
}

pub fn state(edge: &str, delay: f64, kind: &str, name: &str, state: &str) -> String {
    condition(
        edge,
        delay,
        &format!(
            "<ByValueCondition><StoryboardElementStateCondition storyboardElementType=\"{kind}\" storyboardElementRef=\"{name}\" state=\"{state}\"/></ByValueCondition>"
        ),
    )
}
