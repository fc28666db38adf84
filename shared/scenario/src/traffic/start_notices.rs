//! Notices on how the vehicles of an OpenSCENARIO file begin.
//!
//! The standard counts the heading of a lane position from the road's reference line, in every lane. Players such as
//! esmini and CARLA count it from the lane's traffic. A file that was made with one of them shows another scene here.

use openscenario::model::{Category, Script};
use openscenario::{LaneHeadings, Motion, World};

/// Notices of an ego that stands, and of vehicles whose direction the user should check.
pub(crate) fn of(script: &Script, world: &World, headings: LaneHeadings) -> Vec<String> {
    let ego = world.motion(script.ego);
    let mut notices = Vec::new();
    if ego.present && ego.speed_mps == 0.0 {
        notices.push(
            "the ego begins with 0 m/s, which is its set speed too, unless `--set set_speed_mps=15` gives \
             one"
                .to_owned(),
        );
    }
    for (index, entity) in script.entities.iter().enumerate() {
        if entity.category == Category::Vehicle && headings == LaneHeadings::Road {
            notices.extend(against_its_lane(script, &entity.name, world.motion(index)));
        }
    }
    notices
}

/// A notice if a vehicle on a lane faces against the lane's traffic.
fn against_its_lane(script: &Script, name: &str, motion: Motion) -> Option<String> {
    let Motion { row, s_m, t_m, .. } = motion;
    let road = &script.roads[row];
    let lane = road.lane_at(s_m, t_m).filter(|_| motion.present && road.holds(s_m, t_m))?;
    if motion.direction() == road.direction(&lane) {
        return None;
    }
    let is_along = (motion.direction() > 0.0) != road.part_at(s_m).reversed;
    let (id, h) = (lane.id, if is_along { "3.14159" } else { "0" });
    Some(format!(
        "`{name}` begins in lane {id} and faces against its traffic: orientations count from the road's \
         reference line. h=\"{h}\" would face with the lane; `--lane-headings traffic` counts from the \
         lane's traffic, as esmini and CARLA do"
    ))
}
