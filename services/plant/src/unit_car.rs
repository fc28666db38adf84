//! The ego as a unit of the Functional Mock-up Interface (`plant.fmu`).
//!
//! The unit moves in a process of its own, which is hosted as a law's program is. The plant's own car stands by with the
//! unit's last motion:
//!
//! | | in real time | in simulated time |
//! | --- | --- | --- |
//! | no answer in half a period | the own car moves; the unit makes up for the period at its next answer | waited for |
//! | a wrong answer, the process ends | the own car moves until a new unit goes on from its speed | the run ends: status 1 |
//!
//! A unit without an acceleration as its input has pedals. The share of the strongest acceleration or deceleration is
//! pressed, and an integral of the acceleration's error corrects it.

use crate::longitudinal::{State, Vehicle};
use fmi::{Motion, Request};
use messages::Service;
use runtime::RuntimeError;
use runtime::hosted::{Hosting, Life, Plan, Proof, Reply};
use scenario::Scenario;
use scenario::plant::Plant;
use std::path::Path;
use std::time::Duration;

/// Time for the first answer, and in simulated time for each. Chosen, as the law's.
const PATIENCE: Duration = Duration::from_secs(8);
/// Time without an answer after which a unit is replaced. Chosen, as the law's.
const SILENCE: Duration = Duration::from_millis(500);
/// Gain of the integral on the acceleration's error, share of the strongest acceleration by s. Chosen.
const INTEGRAL_GAIN: f64 = 1.0;

/// The time of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    pub(crate) time_s: f64,
    /// Time for the answer; none in simulated time.
    pub(crate) left: Option<Duration>,
}

/// The unit, and the own car with its motion.
pub(crate) struct UnitCar {
    pub(crate) program: Hosting<Request, Motion>,
    /// The own car, which has the unit's motion.
    pub(crate) own: Vehicle,
    pedals: Pedals,
    period_s: f64,
    /// Place of the unit's position 0 on the axis, m.
    origin_m: Option<f64>,
    /// Periods in which the own car moved.
    own_periods: u64,
    /// Fault of the first refused answer.
    refusal: Option<String>,
}

impl UnitCar {
    pub(crate) fn open(scenario: &Scenario, unit: &Path) -> Result<Self, RuntimeError> {
        let plant = &scenario.plant;
        let period_s = 1e-3 * f64::from(plant.period_ms.value());
        let plan = Plan {
            part: "vehicle",
            command: [vec![unit.display().to_string()], plant.unit_words()].concat(),
            variables: Vec::new(),
            directory: unit.parent().unwrap_or(Path::new("/")).to_path_buf(),
            patience: PATIENCE,
            silence: SILENCE,
            supervision: scenario.supervision.clone(),
        };
        let speed_mps = plant.initial_speed_mps.value();
        let proof = Proof {
            question: Request { sequence: 1, reset: 1, period_s, speed_mps, ..Request::default() },
            check,
            service: Service::Plant,
        };
        let mut program = Hosting::new(plan, proof);
        program.start().map_err(|error| RuntimeError::Program(error.into()))?;
        Ok(Self {
            program,
            own: Vehicle::new(plant),
            pedals: Pedals::new(plant),
            period_s,
            origin_m: None,
            own_periods: 0,
            refusal: None,
        })
    }

    pub(crate) fn restore(&mut self, own: Vehicle) {
        self.own = own;
        self.program.forget();
    }

    pub(crate) fn place(&mut self, position_m: f64) {
        let moved_m = position_m - self.own.state().position_m;
        self.origin_m = self.origin_m.map(|origin_m| origin_m + moved_m);
        self.own.place(position_m);
    }

    /// Moves on by one period under a request, m/s². A unit that fails is an error in simulated time.
    pub(crate) fn step(&mut self, request_mps2: f64, moment: Moment) -> Result<(), RuntimeError> {
        let before = self.own.state();
        let (throttle, brake) = self.pedals.press(request_mps2, &before, self.period_s);
        let (period_s, speed_mps) = (self.period_s, before.speed_mps);
        let mut is_anew = false;
        let asked = self.program.ask(moment.left, |sequence, reset| {
            is_anew = reset;
            let (reset, time_s) = (reset.into(), moment.time_s);
            Request { sequence, reset, time_s, period_s, request_mps2, throttle, brake, speed_mps }
        });
        match asked.map_err(|error| RuntimeError::Program(error.into()))? {
            Reply::Answer(motion) => match check(&motion) {
                Ok(()) => {
                    if is_anew {
                        self.origin_m = None;
                    }
                    let state = self.moved(&before, &motion);
                    self.own.go_on_from(state);
                    return Ok(());
                }
                Err(reason) => {
                    let fault = format!("{} answered {reason}", self.program.plan.subject());
                    if moment.left.is_none() {
                        return Err(RuntimeError::Program(fault.into()));
                    }
                    self.refusal.get_or_insert(fault);
                }
            },
            Reply::Late | Reply::Absent => {}
        }
        self.own_periods += 1;
        self.own.step(request_mps2);
        Ok(())
    }

    /// The motion after a period. It never goes back.
    fn moved(&mut self, before: &State, motion: &Motion) -> State {
        let speed_mps = motion.speed_mps.max(0.0);
        let driven_m = before.position_m + 0.5 * (before.speed_mps + speed_mps) * self.period_s;
        let position_m = match motion.has_position {
            0 => driven_m,
            _ => {
                let origin_m = self.origin_m.get_or_insert(driven_m - motion.position_m);
                *origin_m + motion.position_m
            }
        };
        let acceleration_mps2 = match motion.has_acceleration {
            0 => (speed_mps - before.speed_mps) / self.period_s,
            _ => motion.acceleration_mps2,
        };
        State {
            position_m: position_m.max(before.position_m),
            speed_mps,
            acceleration_mps2: match speed_mps > 0.0 {
                true => acceleration_mps2,
                false => acceleration_mps2.max(0.0),
            },
        }
    }

    /// Faults of the unit for people; none if it drove all of the run.
    pub(crate) fn note(&self) -> Option<String> {
        let Life { failures, .. } = self.program.life();
        let faults: Vec<_> = self.refusal.clone().into_iter().chain(failures).collect();
        (self.own_periods > 0).then(|| {
            let subject = self.program.plan.subject();
            let periods = self.own_periods;
            let why = if faults.is_empty() { "it was late".to_owned() } else { faults.join("; ") };
            format!("{subject} was replaced by the plant's own car in {periods} periods: {why}")
        })
    }
}

/// Refuses an answer that no vehicle gives.
fn check(motion: &Motion) -> Result<(), String> {
    let values = [
        ("speed_mps", motion.speed_mps),
        ("position_m", motion.position_m),
        ("acceleration_mps2", motion.acceleration_mps2),
    ];
    match values.into_iter().find(|(_, value)| !value.is_finite()) {
        Some((name, value)) => Err(format!("{name} = {value}, expected a finite number")),
        None => Ok(()),
    }
}

struct Pedals {
    most_mps2: f64,
    least_mps2: f64,
    integral: f64,
}

impl Pedals {
    fn new(plant: &Plant) -> Self {
        Self {
            most_mps2: plant.max_acceleration_mps2.value(),
            least_mps2: plant.min_acceleration_mps2.value(),
            integral: 0.0,
        }
    }

    /// Throttle and brake, 0 to 1.
    fn press(&mut self, request_mps2: f64, state: &State, period_s: f64) -> (f64, f64) {
        let strongest = if request_mps2 < 0.0 { -self.least_mps2 } else { self.most_mps2 };
        let error = (request_mps2 - state.acceleration_mps2) / strongest;
        let share = request_mps2 / strongest;
        let stands = state.speed_mps == 0.0 && request_mps2 <= 0.0;
        let integral = self.integral + INTEGRAL_GAIN * error * period_s;
        // A pedal at its end, or of a standing car, winds nothing up.
        self.integral = if stands { 0.0 } else { integral.clamp(-1.0 - share, 1.0 - share) };
        let pedal = (share + self.integral).clamp(-1.0, 1.0);
        (pedal.max(0.0), (-pedal).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pedals_bring_the_acceleration_to_the_request_of_a_weaker_car() {
        let mut pedals = Pedals::new(&Plant::default());
        let mut state = State { speed_mps: 20.0, ..State::default() };
        for _ in 0..3000 {
            let (throttle, brake) = pedals.press(1.5, &state, 0.01);
            assert!((0.0..=1.0).contains(&throttle) && (0.0..=1.0).contains(&brake));
            // It gives 3 m/s² where 5 are expected, and has a drag of 0.4.
            let free_mps2 = 3.0 * throttle - 6.0 * brake - 0.4;
            state.acceleration_mps2 += 0.05 * (free_mps2 - state.acceleration_mps2);
        }
        assert!((state.acceleration_mps2 - 1.5).abs() < 0.01, "{state:?}");
        let standing = State::default();
        assert_eq!(pedals.press(-0.9, &standing, 0.01), (0.0, 0.1));
    }
}
