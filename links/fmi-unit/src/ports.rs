//! The variables of an exported unit, and its model description.

/// A variable, whose number is its place in the list.
pub struct Port {
    pub name: &'static str,
    /// Its part in the model description.
    pub part: &'static str,
    /// Value until the master sets another.
    pub start: f64,
    pub meaning: &'static str,
}

const INPUT: &str = r#"causality="input" variability="continuous""#;
const OUTPUT: &str = r#"causality="output" variability="continuous" initial="calculated""#;
const PARAMETER: &str = r#"causality="parameter" variability="fixed" initial="exact""#;

macro_rules! ports {
    ($($part:ident $name:literal $start:literal $meaning:literal;)*) => {
        &[$(Port { name: $name, part: $part, start: $start, meaning: $meaning }),*]
    };
}

pub const LAW: &[Port] = ports! {
    INPUT "speed_mps" 0.0 "speed of the vehicle";
    INPUT "acceleration_mps2" 0.0 "acceleration of the vehicle";
    INPUT "set_speed_mps" 30.0 "driver's set speed";
    INPUT "speed_limit_mps" 100.0 "legal limit";
    INPUT "has_target" 0.0 "1 if there is a vehicle ahead";
    INPUT "gap_m" 1000.0 "bumper-to-bumper distance to it";
    INPUT "relative_speed_mps" 0.0 "its speed minus the vehicle's";
    INPUT "target_acceleration_mps2" 0.0 "its acceleration";
    OUTPUT "request_mps2" 0.0 "requested acceleration";
};

/// Variables of a law in the loop of a deployment.
pub const LOOP: &[Port] = ports! {
    INPUT "lead_position_m" 1000.0 "rear bumper of the vehicle ahead, from the ego's front bumper at the start";
    INPUT "lead_speed_mps" 30.0 "its speed";
    INPUT "lead_acceleration_mps2" 0.0 "its acceleration";
    INPUT "has_lead" 1.0 "1 if it is there";
    INPUT "set_speed_mps" 30.0 "driver's set speed";
    PARAMETER "initial_speed_mps" 0.0 "speed at the start";
    PARAMETER "delay_ms" 0.0 "delay of each command on its way to the actuators";
    PARAMETER "jitter_ms" 0.0 "largest further delay, uniform";
    PARAMETER "drop_share" 0.0 "share of the commands that are lost";
    PARAMETER "restart_every_s" 0.0 "time between two ends of the controller; 0 for none";
    PARAMETER "restart_ms" 300.0 "time until the next controller commands, with an empty memory";
    PARAMETER "seed" 1.0 "seed of jitter and losses";
    OUTPUT "position_m" 0.0 "way of the ego's front bumper";
    OUTPUT "speed_mps" 0.0 "its speed";
    OUTPUT "acceleration_mps2" 0.0 "its acceleration";
    OUTPUT "request_mps2" 0.0 "request at the actuators";
};

/// Ends of names, the units of measure that they stand for, and what these are in SI.
const UNITS: [(&str, &str, &str); 5] = [
    ("m", "m", r#"m="1""#),
    ("mps", "m/s", r#"m="1" s="-1""#),
    ("mps2", "m/s2", r#"m="1" s="-2""#),
    ("s", "s", r#"s="1""#),
    ("ms", "ms", r#"s="1" factor="0.001""#),
];

/// `modelDescription.xml` of a unit with these variables.
pub fn description(ports: &[Port], name: &str, token: &str, step_s: f64) -> String {
    let unit = |(_, name, base)| format!("    <Unit name=\"{name}\"><BaseUnit {base}/></Unit>\n");
    let units: String = UNITS.map(unit).concat();
    let variable = |(number, port): (usize, &Port)| {
        let Port { name, part, start, meaning } = port;
        let end = name.rsplit('_').next();
        let unit = UNITS.iter().find(|(of, ..)| Some(*of) == end);
        let unit = unit.map_or(String::new(), |(_, unit, _)| format!(r#" unit="{unit}""#));
        let start = if *part == OUTPUT { String::new() } else { format!(r#" start="{start}""#) };
        format!(
            r#"    <ScalarVariable name="{name}" valueReference="{number}" {part} description="{meaning}"><Real{unit}{start}/></ScalarVariable>"#
        )
    };
    let variables = ports.iter().enumerate().map(variable).collect::<Vec<_>>().join("\n");
    let outputs = ports.iter().zip(1..).filter(|(port, _)| port.part == OUTPUT);
    let unknowns: String = outputs.map(|(_, k)| format!(r#"<Unknown index="{k}"/>"#)).collect();
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{token}" generationTool="timegap" variableNamingConvention="flat">
  <CoSimulation modelIdentifier="unit" needsExecutionTool="false" canHandleVariableCommunicationStepSize="true"/>
  <UnitDefinitions>
{units}  </UnitDefinitions>
  <DefaultExperiment stepSize="{step_s}"/>
  <ModelVariables>
{variables}
  </ModelVariables>
  <ModelStructure><Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns></ModelStructure>
</fmiModelDescription>
"#
    )
}
