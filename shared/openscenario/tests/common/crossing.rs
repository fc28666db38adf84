//! A crossing of four roads.
//!
//! ```text
//!            4
//!            |        Each road is 190 or 200 m long and has the lanes -1 and 1 of 4 m.
//!     0 ─────┼───── 2 Ways through it, with a lane -1: 10 from 0 to 2, 11 from 3 to 4, 12 from 0 to 4,
//!            |        13 from 3 to 2. The lines of 12 and 13 are in the middle of their lanes.
//!            3
//! ```

use std::f64::consts::{FRAC_PI_2, PI};

fn lane(id: i32, links: &str) -> String {
    format!(
        "<lane id=\"{id}\"><link>{links}</link><width sOffset=\"0\" a=\"4\" b=\"0\" c=\"0\" d=\"0\"/></lane>"
    )
}

/// A road with its line: x, y, heading, curvature, length.
fn road(id: &str, junction: &str, links: &str, line: [f64; 5], lanes: &str) -> String {
    let [x, y, heading, curvature, length] = line;
    let shape = match curvature == 0.0 {
        true => "<line/>".to_owned(),
        false => format!("<arc curvature=\"{curvature}\"/>"),
    };
    format!(
        "<road id=\"{id}\" junction=\"{junction}\" length=\"{length}\"><link>{links}</link><planView>\
         <geometry s=\"0\" x=\"{x}\" y=\"{y}\" hdg=\"{heading}\" length=\"{length}\">{shape}</geometry></planView>\
         <lanes>{lanes}</lanes></road>\n"
    )
}

pub fn net() -> String {
    let both = format!(
        "<laneSection s=\"0\"><left>{}</left><right>{}</right></laneSection>",
        lane(1, ""),
        lane(-1, "")
    );
    let outside = |id: &str, end: &str, line| {
        let link = format!("<{end} elementType=\"junction\" elementId=\"9\"/>");
        road(id, "-1", &link, line, &both)
    };
    let inside = |id: &str, [from, to]: [&str; 2], line, offset_m: f64| {
        let link = |name: &str, to: &str, at: &str| {
            format!("<{name} elementType=\"road\" elementId=\"{to}\" contactPoint=\"{at}\"/>")
        };
        let own = lane(-1, "<predecessor id=\"-1\"/><successor id=\"-1\"/>");
        let lanes = format!(
            "<laneOffset s=\"0\" a=\"{offset_m}\" b=\"0\" c=\"0\" d=\"0\"/><laneSection s=\"0\"><right>{own}</right></laneSection>"
        );
        let links = link("predecessor", from, "end") + &link("successor", to, "start");
        road(id, "9", &links, line, &lanes)
    };
    let roads = [
        outside("0", "successor", [-200.0, 0.0, 0.0, 0.0, 190.0]),
        outside("2", "predecessor", [10.0, 0.0, 0.0, 0.0, 200.0]),
        outside("3", "successor", [0.0, -200.0, FRAC_PI_2, 0.0, 190.0]),
        outside("4", "predecessor", [0.0, 10.0, FRAC_PI_2, 0.0, 200.0]),
        inside("10", ["0", "2"], [-10.0, 0.0, 0.0, 0.0, 20.0], 0.0),
        inside("11", ["3", "4"], [0.0, -10.0, FRAC_PI_2, 0.0, 20.0], 0.0),
        inside("12", ["0", "4"], [-10.0, -2.0, 0.0, 1.0 / 12.0, 6.0 * PI], 2.0),
        inside("13", ["3", "2"], [2.0, -10.0, FRAC_PI_2, -0.125, 4.0 * PI], 2.0),
    ];
    let connection = |from: &str, over: &str| {
        format!(
            "<connection id=\"{over}\" incomingRoad=\"{from}\" connectingRoad=\"{over}\" contactPoint=\"start\">\
             <laneLink from=\"-1\" to=\"-1\"/></connection>"
        )
    };
    let ways = [("0", "12"), ("0", "10"), ("3", "13"), ("3", "11")];
    let ways: String = ways.iter().map(|(from, over)| connection(from, over)).collect();
    format!("<OpenDRIVE>{}<junction id=\"9\">{ways}</junction></OpenDRIVE>", roads.concat())
}

/// A road 0 of 200 m with the lanes -1 and -2. Lane -1 leads straight on over 21 to 2, lane -2 bends off over 22 to 3.
pub fn exit() -> String {
    let right = |lanes: &str| format!("<laneSection s=\"0\"><right>{lanes}</right></laneSection>");
    let (one, two) = (right(&lane(-1, "")), right(&(lane(-1, "") + &lane(-2, ""))));
    let link = |name: &str, to: &str| {
        format!("<{name} elementType=\"road\" elementId=\"{to}\" contactPoint=\"start\"/>")
    };
    let linked = right(&lane(-1, "<successor id=\"-1\"/>"));
    // An arc of 50 m to the right, 0.4 rad long.
    let end = [200.0 + 50.0 * 0.4_f64.sin(), -4.0 - 50.0 * (1.0 - 0.4_f64.cos()), -0.4, 0.0, 200.0];
    let junction = "<successor elementType=\"junction\" elementId=\"9\"/>";
    let roads = [
        road("0", "-1", junction, [0.0, 0.0, 0.0, 0.0, 200.0], &two),
        road("21", "9", &link("successor", "2"), [200.0, 0.0, 0.0, 0.0, 20.0], &linked),
        road("22", "9", &link("successor", "3"), [200.0, -4.0, 0.0, -0.02, 20.0], &linked),
        road("2", "-1", "", [220.0, 0.0, 0.0, 0.0, 200.0], &one),
        road("3", "-1", "", end, &one),
    ];
    let ways = [("21", -1), ("22", -2)].map(|(over, from)| {
        format!(
            "<connection id=\"{over}\" incomingRoad=\"0\" connectingRoad=\"{over}\" contactPoint=\"start\">\
             <laneLink from=\"{from}\" to=\"-1\"/></connection>"
        )
    });
    let ways = ways.concat();
    format!("<OpenDRIVE>{}<junction id=\"9\">{ways}</junction></OpenDRIVE>", roads.concat())
}
