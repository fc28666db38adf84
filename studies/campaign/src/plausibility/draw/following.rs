//! Drives behind a lead, and on a free road.

use super::Draws;
use super::vehicles::{LAWS, actor, head, led, waves, with_radar};

pub fn free_road(draws: &mut Draws) -> String {
    let (speed_mps, set_mps) = (draws.between(0.0, 36.0), draws.between(8.0, 38.0));
    head(draws, 60.0, speed_mps, set_mps)
}

pub fn steady_lead(draws: &mut Draws) -> String {
    let speed_mps = draws.between(3.0, 34.0);
    let mut text = head(draws, 60.0, speed_mps, speed_mps + 3.0);
    led(draws, &mut text, speed_mps, "");
    text
}

pub fn ideal_radar(draws: &mut Draws) -> String {
    let speed_mps = draws.between(5.0, 30.0);
    let law = draws.one(&LAWS);
    let radar = "[perception]\nideal = true\n";
    let mut text = with_radar(draws, (60.0, speed_mps, speed_mps + 3.0), law, radar);
    let profile = if draws.chance(0.5) { String::new() } else { waves(draws, speed_mps) };
    led(draws, &mut text, speed_mps, &profile);
    text
}

pub fn object_list(draws: &mut Draws) -> String {
    let speed_mps = draws.between(5.0, 30.0);
    let law = draws.one(&LAWS);
    let radar = format!(
        "[perception.radar]\nmodel = \"object-list\"\nlatency_ms = {}\nrange_sigma_m = {:.2}\n\
         range_rate_sigma_mps = {:.3}\n",
        draws.one(&[0, 50, 100]),
        draws.between(0.05, 0.8),
        draws.between(0.03, 0.3),
    );
    let mut text = with_radar(draws, (60.0, speed_mps, speed_mps + 3.0), law, &radar);
    let profile = waves(draws, speed_mps);
    led(draws, &mut text, speed_mps, &profile);
    text
}

pub fn wavy_lead(draws: &mut Draws) -> String {
    let speed_mps = draws.between(5.0, 30.0);
    let mut text = head(draws, 80.0, speed_mps, speed_mps + 8.0);
    let profile = waves(draws, speed_mps);
    led(draws, &mut text, speed_mps, &profile);
    text
}

pub fn braking_lead(draws: &mut Draws) -> String {
    let speed_mps = draws.between(10.0, 32.0);
    let (begins_s, braking_mps2) = (draws.between(8.0, 20.0), draws.between(1.0, 6.0));
    let low_mps = if draws.chance(0.5) { 0.0 } else { draws.between(0.0, 0.8) * speed_mps };
    let goes_s = begins_s + (speed_mps - low_mps) / braking_mps2 + draws.between(1.0, 8.0);
    let profile = format!(
        "profile.steps = [{{ time_s = {begins_s:.2}, speed_mps = {low_mps:.2}, acceleration_mps2 = {braking_mps2:.2} }}, \
         {{ time_s = {goes_s:.2}, speed_mps = {speed_mps:.2}, acceleration_mps2 = {:.2} }}]",
        draws.between(0.5, 2.5)
    );
    let mut text = head(draws, goes_s + 15.0, speed_mps, speed_mps + 4.0);
    led(draws, &mut text, speed_mps, &profile);
    text
}

pub fn stop_and_go(draws: &mut Draws) -> String {
    let speed_mps = draws.between(4.0, 15.0);
    let mut time_s = draws.between(4.0, 10.0);
    let mut steps = Vec::new();
    for _ in 0..3 {
        for to_mps in [0.0, speed_mps] {
            let rate_mps2 = draws.between(0.6, 2.5);
            steps.push(format!(
                "{{ time_s = {time_s:.2}, speed_mps = {to_mps:.2}, acceleration_mps2 = {rate_mps2:.2} }}"
            ));
            time_s += speed_mps / rate_mps2 + draws.between(1.0, 8.0);
        }
    }
    let mut text = head(draws, time_s + 5.0, speed_mps, speed_mps + 6.0);
    let profile = format!("profile.steps = [{}]", steps.join(", "));
    led(draws, &mut text, speed_mps, &profile);
    text
}

pub fn clutter(draws: &mut Draws) -> String {
    let speed_mps = draws.between(5.0, 30.0);
    let law = draws.one(&LAWS);
    let radar = format!(
        "[perception.radar]\nlatency_ms = 50\ndropout_probability = {:.3}\n[perception.radar.detections]\n\
         false_alarms_per_scan = {:.1}\nsnr_at_100_m_db = {:.1}\nstanding_objects_per_km = {:.0}\nguard_rail_share = 1\n",
        draws.between(0.0, 0.3),
        draws.between(1.0, 10.0),
        draws.between(8.0, 15.0),
        draws.between(50.0, 300.0),
    );
    let mut text = with_radar(draws, (60.0, speed_mps, speed_mps + 3.0), law, &radar);
    let profile = waves(draws, speed_mps);
    led(draws, &mut text, speed_mps, &profile);
    text
}

pub fn truck(draws: &mut Draws) -> String {
    let speed_mps = draws.between(15.0, 25.0);
    let model = draws.one(&["object-list", "detections"]);
    let filter = draws.one(&["singer", "interacting-models"]);
    let mut text = format!(
        "schema_version = 1\nname = \"\"\nduration_s = 100\nseed = {}\nset_speed_mps = {:.2}\n\
         [plant]\nvehicle = \"{}\"\nperiod_ms = 20\nintegration_step_ms = 20\ninitial_speed_mps = {speed_mps:.2}\n\
         length_m = 16.5\nactuator_time_constant_s = 0.4\nmin_acceleration_mps2 = -6.5\n\
         [road.generated]\nseed = {}\nlength_km = 8\ngrade_sigma_percent = {:.2}\n\
         [perception]\nperiod_ms = 100\nradar = {{ model = \"{model}\", max_range_m = 200 }}\n\
         tracker = {{ filter = \"{filter}\" }}\n\
         [aebs]\ndead_time_ms = 300\njerk_mps3 = 10\ndeceleration_mps2 = 5.5\nmargin_m = 3\n\
         [v2x]\nperiod_ms = 500\n[controller]\nname = \"predictive\"\n",
        draws.number + 1,
        speed_mps + 1.0,
        draws.one(&["jh6-49t", "jh6-25t"]),
        draws.number + 1,
        draws.between(0.3, 1.5),
    );
    let profile = format!(
        "profile.steps = [{{ time_s = {:.1}, speed_mps = {:.1}, acceleration_mps2 = {:.2} }}, \
         {{ time_s = 60, speed_mps = {speed_mps:.1}, acceleration_mps2 = 0.5 }}]",
        draws.between(10.0, 30.0),
        speed_mps * draws.between(0.4, 1.0),
        draws.between(0.3, 2.0)
    );
    led(draws, &mut text, speed_mps, &profile);
    text
}

pub fn cycle(draws: &mut Draws) -> String {
    let cycle = draws.one(&["udds", "hwfet", "us06", "wltc-3b"]);
    let mut text = head(draws, 300.0, 0.0, 38.0);
    actor(&mut text, "lead", 8.0, &format!("profile.cycle = \"{cycle}\""));
    text
}
