//! `[controller]`: which law drives, how often, and its parameters.

use scenario_derive::tables;
use std::path::{Path, PathBuf};

use crate::LawTables;
use crate::name::Name;
use crate::quantity::{
    Acceleration, AccelerationMagnitude, Length, PeriodMs, PositiveWeight, Steps, TimeConstant,
    Weight,
};

tables! {
    /// The control law and its loop. The defaults drive; the paper's scenarios set what differs.
    pub struct Controller {
        /// Name of the law; the registry of the laws has the names.
        pub name: Name = "cacc-mpc",
        /// Period of the control loop, ms.
        pub period_ms: PeriodMs = 100,
        /// The program that the law `external` hosts: its name on the PATH or its path, then its arguments.
        pub command: Vec<String> = sparse,
        /// Directory in which that program runs. If absent, it is the scenario file's if a file of the command is
        /// there, else the current one.
        pub directory: Option<PathBuf>,
        /// Start of a cycle.
        pub release: Release = Radar,
        /// Time from the scheduled release by which a cycle must have finished, ms; absent: the period.
        pub deadline_ms: Option<PeriodMs>,
        /// Desired gap of the predictive laws, and with it their formulation.
        pub spacing_policy: SpacingPolicy = ConstantTimeHeadway,
        /// Solver of the predictive laws.
        pub solver: Solver = Riccati,
        /// Steps of the prediction; `acc-mpc` and `cacc-mpc` take 10 to 128.
        pub horizon: Steps = 100,
        /// Step of the prediction, ms; absent: the period, or 100 ms where that is below 50 or above 500 ms. `acc-mpc`
        /// and `cacc-mpc` take 10 to 500 ms.
        pub prediction_step_ms: Option<PeriodMs>,
        /// Time headway t_h, s.
        pub time_headway_s: TimeConstant = 1.5,
        /// Gap at standstill d_b, m.
        pub standstill_distance_m: Length = 5.0,
        /// Time constant tau of the actuator in the law's model, s.
        pub model_time_constant_s: TimeConstant = 0.5,
        /// Smallest request, m/s² (negative).
        pub min_request_mps2: Acceleration = -6.0,
        /// Largest request, m/s².
        pub max_request_mps2: Acceleration = 4.9,
        /// Weights of the paper's problem.
        pub weights: Weights = default,
        /// Slower driving in curves, on a road with a plan.
        pub curve_speed: CurveSpeed = sparse,
        /// The laws' own tables; the registry of the laws checks them.
        #[serde(flatten, skip_deserializing)]
        pub tables: LawTables = default,
    }

    /// Start of a control cycle.
    pub enum Release {
        /// The radar sample that is due at the same time: the period is a multiple of the radar's.
        Radar,
        /// A timer of its own.
        Timer,
    }

    /// Desired gap of the predictive laws, and with it their optimisation problem.
    pub enum SpacingPolicy {
        /// The paper's problem with v t_h + d_b of the first cycle, then frozen. The figures of its scenarios A, B and
        /// C were made with it.
        ConstantDistance,
        /// The paper's problem with v t_h + d_b measured anew in each cycle, as in its Table 3. The prediction leaves
        /// t_h a out of the error's rate.
        MeasuredHeadway,
        /// Formulation for the road: constant time headway predicted exactly, lead acceleration, set speed.
        ConstantTimeHeadway,
    }

    /// Solver of the predictive laws.
    pub enum Solver {
        /// The stage-wise interior point of this project.
        Riccati,
        /// The general conic solver of the same name.
        Clarabel,
    }

    /// Weights of 1/2 sum(q1 e² + q2 ed² + q3 a² + r u²) + light_weight sum(1/min(D, d_th) - 1/d_th).
    /// The defaults are the set that fits all of the paper's scenarios at once.
    #[derive(Copy)]
    pub struct Weights {
        /// Gap error.
        pub q1: Weight = 19.243,
        /// Speed error.
        pub q2: Weight = 135.712,
        /// Acceleration.
        pub q3: Weight = 0.00159,
        /// Request.
        pub r: PositiveWeight = 1.0,
        /// Light penalty w.
        pub light_weight: Weight = 275_773.0,
        /// Distance d_th at which the light penalty begins, m.
        pub light_threshold_m: Length = 108.5,
        /// Stages of the prediction at which the light penalty counts.
        pub light_stages: LightStages = sparse,
    }

    /// Stages at which the paper's light penalty counts: its equations 15 and 23 differ.
    pub enum LightStages {
        /// Stages before the switch, t_l(k) > 0, as equation 23 says.
        #[default]
        BeforeSwitch,
        /// All stages, as equation 15 is printed.
        All,
    }

    /// Slower driving in curves of a road with a plan.
    #[derive(Copy)]
    pub struct CurveSpeed {
        /// True if the set speed is capped.
        pub enabled: bool = true,
        /// Lateral acceleration that the cap keeps, m/s².
        pub comfort_mps2: Comfort = default,
        /// Deceleration with which the speed falls before a curve, m/s².
        pub braking_mps2: AccelerationMagnitude = 1.0,
    }

    /// Lateral acceleration by speed: `slow` up to 17 m/s, `fast` from 32 m/s on, between them in proportion.
    #[derive(Copy)]
    pub struct Comfort {
        /// Up to 17 m/s, m/s².
        pub slow: AccelerationMagnitude = 2.3,
        /// From 32 m/s on, m/s².
        pub fast: AccelerationMagnitude = 2.0,
    }
}

impl Controller {
    /// Time from the scheduled release by which a cycle must have finished.
    pub fn deadline(&self) -> PeriodMs {
        self.deadline_ms.unwrap_or(self.period_ms)
    }

    /// Step of the prediction: as set, else the period. It is 100 ms if the period is below 50 or above 500 ms.
    pub fn prediction_step(&self) -> PeriodMs {
        let is_a_step = (50..=500).contains(&self.period_ms.value());
        let usual = if is_a_step { self.period_ms } else { PeriodMs::of(100) };
        self.prediction_step_ms.unwrap_or(usual)
    }

    /// Settles where the program of a foreign law runs; `own` is the scenario file's directory.
    pub(crate) fn place_command(&mut self, own: Option<&Path>) {
        self.directory = place_of(&self.command, self.directory.take(), own);
    }
}

/// The directory of the program of `command`: the chosen one, the scenario file's, or the present one. `own` is the
/// scenario file's directory.
pub(crate) fn place_of(
    command: &[String],
    chosen: Option<PathBuf>,
    own: Option<&Path>,
) -> Option<PathBuf> {
    if command.is_empty() {
        return chosen;
    }
    let here = std::env::current_dir().unwrap_or_default();
    let own = own.map(|own| here.join(own));
    let is_file = |directory: &Path| {
        let is_named = |(place, word): &(usize, &String)| {
            !word.starts_with('-') && (*place > 0 || word.contains('/'))
        };
        let mut named = command.iter().enumerate().filter(is_named);
        named.any(|(_, word)| directory.join(word).is_file())
    };
    Some(match (chosen, own) {
        (Some(chosen), own) => own.unwrap_or(here).join(chosen),
        (None, Some(own)) if is_file(&own) || !is_file(&here) => own,
        (None, _) => here,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_runs_where_its_files_are() {
        let own = std::env::temp_dir().join(format!("timegap-place-{}", std::process::id()));
        std::fs::create_dir_all(&own).expect("the temporary directory is writable");
        std::fs::write(own.join("law.py"), "").expect("ours");
        let here = std::env::current_dir().expect("it is somewhere");
        let place = |command: &[&str], directory: Option<&str>, own: Option<&Path>| {
            let mut controller = Controller {
                command: command.iter().map(ToString::to_string).collect(),
                directory: directory.map(PathBuf::from),
                ..Controller::default()
            };
            controller.place_command(own);
            controller.directory
        };
        assert_eq!(place(&[], None, Some(&own)), None);
        assert_eq!(place(&["python3", "law.py"], None, Some(&own)), Some(own.clone()));
        // A test of a package runs in its directory.
        assert_eq!(place(&["python3", "Cargo.toml"], None, Some(&own)), Some(here.clone()));
        assert_eq!(place(&["python3", "no-such.py"], None, Some(&own)), Some(own.clone()));
        assert_eq!(place(&["python3", "law.py"], None, None), Some(here));
        assert_eq!(place(&["python3"], Some("below"), Some(&own)), Some(own.join("below")));
        std::fs::remove_dir_all(&own).expect("ours");
    }
}
