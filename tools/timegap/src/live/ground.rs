//! The road under the live view from above.

use report::{BodySize, RoadView};
use scenario::Scenario;
use serde::Serialize;

/// Road that is drawn beyond both ends of the plan, m.
const AROUND_M: f64 = 100.0;

#[derive(Serialize)]
struct Ground {
    road: RoadView,
    ego: BodySize,
}

/// Road and size of the ego as JSON that is safe inside a script. `null` if the road has no plan.
pub fn json(scenario: &Scenario) -> String {
    let ground = scenario.road.plan().map(|plan| Ground {
        road: RoadView::of(plan, (-AROUND_M, plan.axis().length_m() + AROUND_M)),
        ego: BodySize::of_ego(scenario),
    });
    report::chart::script_json(&ground)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_road_has_no_ground() {
        let text = "schema_version = 1\nname = \"x\"\nset_speed_mps = 10\n";
        let of = |plan: &str| json(&Scenario::parse("x", &format!("{text}{plan}")).expect("right"));
        assert_eq!(of(""), "null");
        let plan = "[road.plan]\npieces = [{ line_m = 500 }]\n";
        let ground: serde_json::Value = serde_json::from_str(&of(plan)).expect("JSON");
        assert_eq!(ground["road"]["lines"].as_array().map(Vec::len), Some(2));
        assert_eq!(ground["ego"]["length"], 4.5);
    }
}
