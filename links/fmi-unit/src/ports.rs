//! The variables of an exported unit, and its model description.

use std::fmt::Write;

/// A variable, whose number is its place in the list.
pub struct Port {
    pub name: &'static str,
    pub part: Part,
    /// Value until the master sets another.
    pub start: f64,
    pub meaning: &'static str,
}

/// Part of a variable.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Part {
    Input,
    Output,
    Parameter,
}

macro_rules! ports {
    ($($part:ident $name:literal $start:literal $meaning:literal;)*) => {
        &[$(Port { name: $name, part: Part::$part, start: $start, meaning: $meaning }),*]
    };
}

/// Variables of a law.
pub const LAW: &[Port] = ports! {
    Input "speed_mps" 0.0 "speed of the vehicle";
    Input "acceleration_mps2" 0.0 "acceleration of the vehicle";
    Input "set_speed_mps" 30.0 "driver's set speed";
    Input "speed_limit_mps" 100.0 "legal limit";
    Input "has_target" 0.0 "1 if there is a vehicle ahead";
    Input "gap_m" 1000.0 "bumper-to-bumper distance to it";
    Input "relative_speed_mps" 0.0 "its speed minus the vehicle's";
    Input "target_acceleration_mps2" 0.0 "its acceleration";
    Output "request_mps2" 0.0 "requested acceleration";
};

/// Variables of a law in the loop of a deployment.
pub const LOOP: &[Port] = ports! {
    Input "lead_position_m" 1000.0 "rear bumper of the vehicle ahead, from the ego's front bumper at the start";
    Input "lead_speed_mps" 30.0 "its speed";
    Input "lead_acceleration_mps2" 0.0 "its acceleration";
    Input "has_lead" 1.0 "1 if it is there";
    Input "set_speed_mps" 30.0 "driver's set speed";
    Parameter "initial_speed_mps" 0.0 "speed at the start";
    Parameter "delay_ms" 0.0 "delay of each command on its way to the actuators";
    Parameter "jitter_ms" 0.0 "largest further delay, uniform";
    Parameter "drop_share" 0.0 "share of the commands that are lost";
    Parameter "restart_every_s" 0.0 "time between two ends of the controller; 0 for none";
    Parameter "restart_ms" 300.0 "time until the next controller commands, with an empty memory";
    Parameter "seed" 1.0 "seed of jitter and losses";
    Output "position_m" 0.0 "way of the ego's front bumper";
    Output "speed_mps" 0.0 "its speed";
    Output "acceleration_mps2" 0.0 "its acceleration";
    Output "request_mps2" 0.0 "request at the actuators";
};

/// `modelDescription.xml` of a unit with these variables.
pub fn description(ports: &[Port], name: &str, token: &str, step_s: f64) -> String {
    let mut text = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{token}" generationTool="timegap" variableNamingConvention="flat">
  <CoSimulation modelIdentifier="unit" needsExecutionTool="false" canHandleVariableCommunicationStepSize="true"/>
  <UnitDefinitions>
    <Unit name="m"><BaseUnit m="1"/></Unit>
    <Unit name="m/s"><BaseUnit m="1" s="-1"/></Unit>
    <Unit name="m/s2"><BaseUnit m="1" s="-2"/></Unit>
    <Unit name="s"><BaseUnit s="1"/></Unit>
    <Unit name="ms"><BaseUnit s="1" factor="0.001"/></Unit>
  </UnitDefinitions>
  <DefaultExperiment stepSize="{step_s}"/>
  <ModelVariables>
"#
    );
    let (mut outputs, mut unknowns) = (String::new(), String::new());
    for (number, Port { name, part, start, meaning }) in ports.iter().enumerate() {
        let (part, is_output) = match part {
            Part::Input => (r#"causality="input" variability="continuous""#, false),
            Part::Output => {
                (r#"causality="output" variability="continuous" initial="calculated""#, true)
            }
            Part::Parameter => {
                (r#"causality="parameter" variability="fixed" initial="exact""#, false)
            }
        };
        let unit = match name.rsplit('_').next() {
            Some("mps") => r#" unit="m/s""#,
            Some("mps2") => r#" unit="m/s2""#,
            Some("m") => r#" unit="m""#,
            Some("s") => r#" unit="s""#,
            Some("ms") => r#" unit="ms""#,
            _ => "",
        };
        let start = if is_output { String::new() } else { format!(r#" start="{start}""#) };
        if is_output {
            let _ = write!(unknowns, r#"<Unknown index="{}"/>"#, number + 1);
        }
        let _ = writeln!(
            outputs,
            r#"    <ScalarVariable name="{name}" valueReference="{number}" {part} description="{meaning}"><Real{unit}{start}/></ScalarVariable>"#
        );
    }
    let _ = write!(
        text,
        "{outputs}  </ModelVariables>\n  <ModelStructure><Outputs>{unknowns}</Outputs>\
         <InitialUnknowns>{unknowns}</InitialUnknowns></ModelStructure>\n</fmiModelDescription>\n"
    );
    text
}
