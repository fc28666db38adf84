//! An ego at constant speed among scripted vehicles, as a scenario. All vehicles have the regulation's length.

use crate::VEHICLE_LENGTH_M;
use controller::laws;
use group::{Error, LawOptions};
use scenario::{Overrides, Scenario};

/// Time gap from which a law closes up or falls back to its own.
const FIRST_TIME_GAP_S: f64 = 2.0;
/// Distance added to that.
const FIRST_DISTANCE_M: f64 = 5.0;
/// Time for which the ego is clear of all others before a run ends, s. It is five cycles of every law, so that a law
/// that turns back to another vehicle shows it.
const CLEAR_S: f64 = 0.5;

/// Driver of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Driver {
    /// The control law.
    pub law: String,
    /// With the emergency brake.
    pub aebs: bool,
}

/// The common part of a study's drives.
#[derive(Clone, Debug, Default)]
pub struct Conditions {
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// Laws of the user's own.
    pub laws: LawOptions,
    /// Requirements that every drive is judged by.
    pub formulas: Vec<String>,
}

/// The ego behind a lead that keeps its speed.
///
/// # Errors
/// [`Error::Scenario`] if there is no such law.
pub fn behind_a_lead(
    speed_kmh: u32,
    driver: &Driver,
    conditions: &Conditions,
    duration_s: f64,
) -> Result<Scenario, Error> {
    let speed_mps = f64::from(speed_kmh) / 3.6;
    let first_gap_m = FIRST_TIME_GAP_S * speed_mps + FIRST_DISTANCE_M;
    let actors = actor("lead", first_gap_m, &format!("initial_speed_mps = {speed_mps}"));
    parse(&Scene { scripted_s: duration_s, duration_s, actors }, speed_mps, driver, conditions)
}

/// Traffic around the ego.
pub(super) struct Scene {
    /// Time after which nothing scripted comes any more, s.
    pub(super) scripted_s: f64,
    /// Length of the run, s.
    pub(super) duration_s: f64,
    /// The vehicles, as TOML.
    pub(super) actors: String,
}

/// The scenario of an ego that drives at `speed_mps` in `scene`.
///
/// # Errors
/// [`Error::Scenario`] if there is no such law.
pub(super) fn parse(
    scene: &Scene,
    speed_mps: f64,
    driver: &Driver,
    conditions: &Conditions,
) -> Result<Scenario, Error> {
    let Scene { scripted_s, duration_s, actors } = scene;
    let Driver { law, aebs } = driver;
    let Conditions { seed, laws: own, formulas } = conditions;
    let text = format!(
        "schema_version = 1\nname = \"r157\"\nduration_s = {duration_s}\nseed = {seed}\n\
         set_speed_mps = {speed_mps}\n\
         [plant]\ninitial_speed_mps = {speed_mps}\n\
         length_m = {VEHICLE_LENGTH_M}\n\
         powertrain = {{ mass_kg = 1600, max_power_kw = 110 }}\n\
         [aebs]\nenabled = {aebs}\n\
         [referee]\nends_when_clear = {{ after_s = {scripted_s}, for_s = {CLEAR_S} }}\n\
         [controller]\nname = \"{law}\"\n{actors}"
    );
    let mut overrides = Overrides::new();
    own.lay_over(&mut overrides)?;
    let mut scenario = Scenario::parse_with("a case of UN R157", &text, &overrides, &laws::check)?;
    scenario.require.formulas.clone_from(formulas);
    group::requirements(&scenario)?;
    Ok(scenario)
}

/// A vehicle `gap_m` ahead of the ego, with these keys, as TOML.
pub(super) fn actor(name: &str, gap_m: f64, keys: &str) -> String {
    format!(
        "[[actors]]\nname = \"{name}\"\ngap_m = {gap_m}\nlength_m = {VEHICLE_LENGTH_M}\n{keys}\n"
    )
}
