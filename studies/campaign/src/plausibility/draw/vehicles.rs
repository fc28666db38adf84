//! The common parts of the scenario files: the car with its law and radar, the vehicles around it.

use std::fmt::Write;

use super::Draws;

/// Laws that drive a car without signals.
pub const LAWS: [&str; 4] = ["acc-mpc", "cacc-mpc", "six-mode", "quadratic-bounded"];

/// The common part of all kinds: vehicle, radar and law.
pub fn head(draws: &mut Draws, duration_s: f64, speed_mps: f64, set_mps: f64) -> String {
    let law = draws.one(&LAWS);
    let latency_ms = draws.one(&[0, 50, 100]);
    let dropout = if draws.chance(0.5) { draws.between(0.0, 0.1) } else { 0.0 };
    let radar = format!(
        "[perception.radar]\nlatency_ms = {latency_ms}\ndropout_probability = {dropout:.3}\n"
    );
    let roadside = format!(
        "[perception.radar.detections]\nstanding_objects_per_km = {:.1}\nguard_rail_share = {:.2}\n\
         false_alarms_per_scan = {:.2}\n",
        draws.between(0.0, 120.0),
        draws.between(0.0, 1.0),
        draws.between(0.0, 3.0),
    );
    let seen = radar + &roadside;
    with_radar(draws, (duration_s, speed_mps, set_mps), law, &seen)
}

/// A car with this law and this radar.
pub fn with_radar(
    draws: &mut Draws,
    (duration_s, speed_mps, set_mps): (f64, f64, f64),
    law: &str,
    radar: &str,
) -> String {
    format!(
        "schema_version = 1\nname = \"\"\nduration_s = {duration_s:.1}\nseed = {}\nset_speed_mps = {set_mps:.2}\n\
         [plant]\ninitial_speed_mps = {speed_mps:.2}\npowertrain = {{ mass_kg = {:.0}, max_power_kw = {:.0} }}\n\
         actuator_time_constant_s = {:.2}\n{radar}[controller]\nname = \"{law}\"\n",
        draws.number + 1,
        draws.between(1_000.0, 2_500.0),
        draws.between(60.0, 200.0),
        draws.between(0.2, 0.6),
    )
}

/// A vehicle; `keys` are its other lines.
pub fn actor(text: &mut String, name: &str, gap_m: f64, keys: &str) {
    writeln!(text, "[[actors]]\nname = \"{name}\"\ngap_m = {gap_m:.2}\n{keys}")
        .expect("a string takes all");
}

/// A lead with this profile, at a settled gap.
pub fn led(draws: &mut Draws, text: &mut String, speed_mps: f64, profile: &str) {
    let gap_m = 5.0 + draws.between(1.2, 3.0) * speed_mps;
    let length_m = draws.one(&[4.5, 4.5, 12.0, 16.5]);
    let keys = format!("initial_speed_mps = {speed_mps:.2}\nlength_m = {length_m}\n{profile}");
    actor(text, "lead", gap_m, &keys);
}

/// Waves of a lead around `speed_mps`.
pub fn waves(draws: &mut Draws, speed_mps: f64) -> String {
    let period_s = draws.between(6.0, 40.0);
    // Half of the speed's swing is amplitude x period / pi: the lead does not stop.
    let most_mps2 = (2.5 * speed_mps / period_s).min(2.5);
    let amplitude_mps2 = draws.between(0.1 * most_mps2, most_mps2);
    format!(
        "profile.sine = {{ amplitude_mps2 = {amplitude_mps2:.3}, period_s = {period_s:.2}, start_s = {:.1} }}",
        draws.between(0.0, 10.0)
    )
}
