//! The scenarios of a string: the first car's, and that of a car behind another.

use controller::laws;
use scenario::Scenario;
use scenario::actor::{Actor, Profile, Sine};
use scenario::event::VEHICLE_WIDTH_M;
use scenario::name::Name;
use scenario::quantity::{
    Acceleration, Distance, Duration, Height, Lateral, Length, OutOfRange, Seed, Speed, Time,
};
use scenario::road::{Road, RoadPoint};
use supervise::UsageError;

use super::motion::Motion;
use super::wave::Wave;

/// Time gap of a first distance that neither law nor scenario gives, s.
const FIRST_TIME_GAP_S: f64 = 2.0;
const FIRST_DISTANCE_M: f64 = 5.0;

/// A string to be driven.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The scenario with each law, repeated along the string.
    pub laws: Vec<Scenario>,
    pub vehicles: usize,
    /// The sine that the lead drives; none: what the scenario says.
    pub wave: Option<Wave>,
}

/// Start of a car of the string.
#[derive(Clone, Copy, Debug, Default)]
pub struct Place {
    /// Index in the string, from 0.
    pub index: usize,
    /// Its front bumper at the start, behind the first car's, m.
    pub behind_first_m: f64,
}

impl Plan {
    pub fn law(&self, index: usize) -> &Scenario {
        &self.laws[index % self.laws.len()]
    }

    /// The seed of the first car.
    pub fn seed(&self) -> u64 {
        self.laws[0].seed.value()
    }

    pub fn first(&self) -> Scenario {
        self.law(0).clone()
    }

    /// The start of every car.
    pub fn places(&self) -> Vec<Place> {
        let first = Some(Place::default());
        let behind = |place: &Place| {
            let gap_m = first_gap(self.law(place.index + 1));
            let length_m = self.law(place.index).plant.length_m.value();
            let behind_first_m = place.behind_first_m + length_m + gap_m;
            Some(Place { index: place.index + 1, behind_first_m })
        };
        std::iter::successors(first, behind).take(self.vehicles).collect()
    }

    /// The scenario of a car at `place` behind one that moved like `motion`.
    pub fn behind(&self, place: Place, motion: &Motion) -> Result<Scenario, UsageError> {
        let Place { index, behind_first_m } = place;
        let before = self.law(index - 1);
        let mut scenario = self.law(index).clone();
        let gap_m = first_gap(&scenario);
        let too_long = |_| {
            let place = format_args!("car {}", index + 1);
            UsageError::at(place, "the string is too long", "fewer cars, or shorter gaps")
        };
        scenario.actors = vec![Actor {
            profile: Profile::Speeds(motion.points().to_vec()),
            ..actor("ahead", Distance::try_from(gap_m).map_err(too_long)?, before.plant.length_m)
        }];
        scenario.storyboard = None;
        // Noise of its own.
        let seed = scenario.seed.value().wrapping_add(index as u64) & i64::MAX.unsigned_abs();
        scenario.seed = Seed::of(seed);
        for signal in &mut scenario.v2x.signals {
            let line_m = signal.stop_line_m.value() + behind_first_m;
            signal.stop_line_m = Distance::try_from(line_m).map_err(too_long)?;
        }
        if scenario.road.plan().is_some() {
            let why = "a string drives on a straight road";
            return Err(UsageError::at("road.plan", why, "a scenario without it"));
        }
        if !scenario.road.is_level() {
            scenario.road = moved(&scenario.road, behind_first_m)?;
        }
        Ok(scenario)
    }

    /// The same string behind a lead whose speed is a sine.
    pub fn behind_wave(&self, hz: f64) -> Result<Self, UsageError> {
        let wave = Wave::of(&self.laws[0], self.vehicles, hz)?;
        let laws = self.laws.iter().map(|scenario| {
            let mut scenario = scenario.clone();
            let speed_mps = |mps| Speed::try_from(mps);
            scenario.plant.initial_speed_mps = speed_mps(wave.first_speed_mps())?;
            scenario.plant.initial_acceleration_mps2 = Acceleration::of(0.0);
            let distance_m = Distance::try_from(first_gap(&scenario))?;
            let sine = Sine {
                amplitude_mps2: Acceleration::try_from(wave.acceleration_mps2())?,
                period_s: Duration::try_from(1.0 / hz)?,
                start_s: Time::of(0.0),
            };
            scenario.actors = vec![Actor {
                initial_speed_mps: Some(speed_mps(wave.first_speed_mps())?),
                profile: Profile::Sine(sine),
                ..actor("wave", distance_m, scenario.plant.length_m)
            }];
            scenario.duration_s = Duration::try_from(wave.duration_s())?;
            scenario.storyboard = None;
            scenario.v2x.signals.clear();
            Ok(scenario)
        });
        Ok(Self {
            laws: laws.collect::<Result<_, OutOfRange<f64>>>().map_err(out_of_range)?,
            vehicles: self.vehicles,
            wave: Some(wave),
        })
    }
}

/// A vehicle in the middle of the lane that keeps the speed that is set for it.
fn actor(name: &str, gap_m: Distance, length_m: Length) -> Actor {
    Actor {
        name: Name::of(name),
        gap_m,
        initial_speed_mps: None,
        max_speed_mps: None,
        length_m,
        width_m: Length::of(VEHICLE_WIDTH_M),
        lateral_offset_m: Lateral::of(0.0),
        appears_at_s: Time::of(0.0),
        leaves_at_s: None,
        profile: Profile::Constant,
        lateral: Vec::new(),
        events: Vec::new(),
    }
}

/// The gap at which a car begins: the one that its law aims at, else the scenario's own.
fn first_gap(scenario: &Scenario) -> f64 {
    let speed_mps = scenario.plant.initial_speed_mps.value();
    let desired = laws::desired_gap(scenario).map(|desired| desired.at(speed_mps));
    let own = || scenario.actors.first().map(|actor| actor.gap_m.value());
    desired.or_else(own).unwrap_or(FIRST_TIME_GAP_S * speed_mps + FIRST_DISTANCE_M)
}

/// A figure of the string that no scenario takes.
fn out_of_range(error: OutOfRange<f64>) -> UsageError {
    let OutOfRange { value, range } = error;
    UsageError::at("the string", format_args!("{value} is out of range"), range)
}

/// The road of a car that begins `behind_m` farther back; before its first point it is level.
fn moved(road: &Road, behind_m: f64) -> Result<Road, UsageError> {
    let profile = road.profile();
    let profile =
        profile.map_err(|problem| UsageError::at("road", problem.message, problem.expected))?;
    let points = profile.points().iter().map(|point| {
        let distance_m = Distance::try_from(point.distance_m + behind_m)?;
        Ok(RoadPoint(distance_m, Height::try_from(point.height_m)?))
    });
    let points = points.collect::<Result<Vec<_>, _>>().map_err(out_of_range)?;
    Ok(Road { points, ..Road::default() })
}

#[cfg(test)]
mod tests {
    use supervise::ScenarioOptions;

    use super::*;

    fn plan(name: &str, laws: &[&str]) -> Plan {
        let open = |law: &&str| {
            let options =
                ScenarioOptions { controller: Some((*law).into()), ..ScenarioOptions::default() };
            supervise::open(name, &options).unwrap_or_else(|error| panic!("{error}"))
        };
        Plan { laws: laws.iter().map(open).collect(), vehicles: 5, wave: None }
    }

    #[test]
    fn a_follower_is_a_scenario_that_a_process_can_read() {
        let plan = plan("following", &["acc-mpc", "six-mode"]);
        let motion = Motion::constant(22.0);
        let places = plan.places();
        for (pair, law) in places.windows(2).zip(["six-mode", "acc-mpc", "six-mode", "acc-mpc"]) {
            let [place, next] = pair else { panic!("two of them") };
            let scenario = plan.behind(*next, &motion).expect("a short string");
            assert_eq!(scenario.controller.name.as_str(), law);
            let again = Scenario::parse("again", &scenario.to_toml());
            assert_eq!(again.unwrap_or_else(|error| panic!("{error}")), scenario);
            assert!(next.behind_first_m > place.behind_first_m + 30.0);
        }
    }

    #[test]
    fn signals_and_roads_stay_where_they_are() {
        let plan = plan("corridor", &["cacc-mpc"]);
        let place = plan.places()[1];
        let scenario = plan.behind(place, &Motion::constant(10.0)).expect("a short string");
        for (mine, first) in scenario.v2x.signals.iter().zip(&plan.laws[0].v2x.signals) {
            let moved_m = mine.stop_line_m.value() - first.stop_line_m.value();
            assert!((moved_m - place.behind_first_m).abs() < 1e-9);
        }
        let plan = self::plan("truck-hills", &["predictive"]);
        let place = plan.places()[1];
        let scenario = plan.behind(place, &Motion::constant(20.0)).expect("a short string");
        let first = plan.laws[0].road.profile().expect("a road").points()[1];
        let points = &scenario.road.points;
        let mine = points[1];
        assert!((mine.0.value() - first.distance_m - place.behind_first_m).abs() < 1e-9);
        assert_eq!(mine.1.value(), first.height_m);
    }

    #[test]
    fn a_wave_replaces_the_traffic_and_leaves_the_rest() {
        let plan = plan("cacc-a", &["acc-mpc"]);
        let behind = plan.behind_wave(0.05).expect("a wave");
        let scenario = &behind.laws[0];
        assert!(scenario.v2x.signals.is_empty() && scenario.actors.len() == 1);
        assert_eq!(scenario.controller, plan.laws[0].controller);
        assert!(Scenario::parse("again", &scenario.to_toml()).is_ok());
    }
}
