//! The tests of ISO 15622 as scenarios.

use super::curves::Curve;
use controller::laws;
use group::{Error, LawOptions};
use scenario::{Overrides, Scenario};

/// Time when the lead of [`Test::StopAndGo`] brakes, s.
pub const BRAKES_AT_S: f64 = 25.0;
/// Time when it moves off again, s.
pub const MOVES_OFF_AT_S: f64 = 50.0;
/// Speed of the two vehicles beside each other in [`Test::Discrimination`], m/s.
pub const SIDE_BY_SIDE_MPS: f64 = 24.0;
/// Set speed in [`Test::Acquisition`], m/s.
pub const APPROACH_MPS: f64 = 30.0;

/// A test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Test {
    /// A slower vehicle comes into the radar's range.
    Acquisition,
    /// Two vehicles drive side by side. The one in the lane speeds up, and the ego with it.
    Discrimination,
    /// A lead brakes to standstill, waits and moves off.
    StopAndGo,
    /// The ego follows through a curve.
    Curve(Curve),
}

impl Test {
    /// All tests.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        let straight = [Self::Acquisition, Self::Discrimination, Self::StopAndGo];
        straight.into_iter().chain(Curve::ALL.into_iter().map(Self::Curve))
    }

    /// Its name in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Acquisition => "acquisition",
            Self::Discrimination => "discrimination",
            Self::StopAndGo => "stop-and-go",
            Self::Curve(curve) => curve.name(),
        }
    }

    /// Its scenario for `law`, which may be one of the user's `own`.
    ///
    /// # Errors
    /// [`Error::Scenario`] if there is no such law.
    pub fn scenario(self, law: &str, own: &LawOptions, seed: u32) -> Result<Scenario, Error> {
        let (duration_s, set_mps, initial_mps, actors) = match self {
            Self::Acquisition => (60.0, APPROACH_MPS, APPROACH_MPS, ACQUISITION.to_owned()),
            Self::Discrimination => {
                (90.0, APPROACH_MPS, SIDE_BY_SIDE_MPS, DISCRIMINATION.to_owned())
            }
            Self::StopAndGo => (70.0, 25.0, 20.0, STOP_AND_GO.to_owned()),
            Self::Curve(curve) => {
                let (set_mps, initial_mps) = curve.speeds_mps();
                (curve.duration_s(), set_mps, initial_mps, curve.tables())
            }
        };
        let text = format!(
            "schema_version = 1\nname = \"iso15622\"\nduration_s = {duration_s}\nseed = {seed}\n\
             set_speed_mps = {set_mps}\n\
             [plant]\ninitial_speed_mps = {initial_mps}\n\
             powertrain = {{ mass_kg = 1600, max_power_kw = 110 }}\n\
             [aebs]\nenabled = false\n\
             [controller]\nname = \"{law}\"\n{actors}"
        );
        let mut overrides = Overrides::new();
        own.lay_over(&mut overrides)?;
        Ok(Scenario::parse_with("a test of ISO 15622", &text, &overrides, &laws::check)?)
    }
}

const ACQUISITION: &str = "\
[[actors]]
name = \"target\"
gap_m = 250
initial_speed_mps = 22
";

const DISCRIMINATION: &str = "\
[[actors]]
name = \"lead\"
gap_m = 50
initial_speed_mps = 24
profile.steps = [{ time_s = 20, speed_mps = 27, acceleration_mps2 = 0.5 }]

[[actors]]
name = \"neighbour\"
gap_m = 50
initial_speed_mps = 24
lateral_offset_m = 3.5
";

const STOP_AND_GO: &str = "\
[[actors]]
name = \"lead\"
gap_m = 40
initial_speed_mps = 20
profile.steps = [
    { time_s = 25, speed_mps = 0, acceleration_mps2 = 2.5 },
    { time_s = 50, speed_mps = 10, acceleration_mps2 = 1 },
]
";

#[cfg(test)]
mod tests {
    use scenario::actor::Profile;

    use super::*;

    #[test]
    fn every_test_is_a_scenario_and_its_times_are_those_named() {
        for test in Test::all() {
            test.scenario("acc-mpc", &LawOptions::default(), 1)
                .unwrap_or_else(|error| panic!("{error}"));
        }
        let scenario =
            Test::StopAndGo.scenario("acc-mpc", &LawOptions::default(), 1).expect("it is right");
        let Profile::Steps(steps) = &scenario.actors[0].profile else { panic!("it has steps") };
        let times: Vec<f64> = steps.iter().map(|step| step.time_s.value()).collect();
        assert_eq!(times, [BRAKES_AT_S, MOVES_OFF_AT_S]);
    }
}
