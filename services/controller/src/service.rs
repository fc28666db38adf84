//! The control loop: wait, sample, decide, ask the law, bound its request, publish.

mod account;
mod curves;
mod inputs;
mod publication;

use self::account::Account;
use self::curves::CurveTopics;
use self::inputs::Inputs;
use crate::ladder::{Admission, Ages, Ladder};
use crate::law::{Descriptor, Formulation, Input, Law, MAX_FIGURES, MAX_PLAN, Output};
use crate::laws::external::{Asked, EXTERNAL, Questions};
use crate::planning_thread::PlanningThread;
use crate::plausibility::estimate::EgoEstimate;
use crate::plausibility::{Plausibility, TrustedInputs};
use crate::report::ControllerReport;
use crate::sampling::{Samples, Setting, input};
use messages::level::Level;
use messages::{Command, Diagnostics, FIGURES, Header, PLAN_LEN, Service, ServiceState};
use runtime::statistics::{Latencies, Percentiles};
use runtime::{
    Cycle, Figures, Group, Mode, Overrun, Publisher, Release, Runtime, RuntimeError, Subscriber,
    monotonic_ns,
};
use scenario::{Scenario, controller};
use std::time::Duration;

/// Name of the law's times, which outlive the process.
const LAW: &str = "law";
/// Part of the control period after which the loop no longer waits for the radar to release it.
const FALLBACK: f64 = 0.5;

const _: () = assert!(MAX_PLAN == PLAN_LEN, "a command carries every plan");
const _: () = assert!(MAX_FIGURES == FIGURES, "the diagnostics carry every figure");

/// Runs the controller in its group, to the end of the run.
///
/// # Errors
/// If the group's shared memory is not usable or the scenario's law cannot be set up.
pub fn run(runtime: Runtime) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let law = crate::laws::of(&scenario)?;
    run_law(runtime, law)
}

/// Runs one law in the group, whatever law the scenario names, to the end of the run.
///
/// # Errors
/// If the group's shared memory is not usable or the law refuses the scenario's settings.
pub fn run_law(runtime: Runtime, law: &'static Descriptor) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let built = (law.build)(&crate::law::Reader::new(&scenario))?;
    run_built(runtime, law, built)
}

/// Runs the law that the caller of a run in one process computes, to the end of the run. It is asked through
/// `questions`.
///
/// # Errors
/// If this is not a run in one process.
pub fn run_asked(runtime: Runtime, questions: Questions) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let law = Asked::new(questions, runtime.turns(), &scenario);
    run_built(runtime, &EXTERNAL, Box::new(law))
}

/// Runs a law of the kind that `descriptor` describes, to the end of the run.
fn run_built(
    mut runtime: Runtime,
    descriptor: &'static Descriptor,
    law: Box<dyn Law>,
) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let mut controller = Loop::open(&mut runtime, &scenario, descriptor, law)?;
    runtime.begin(&scenario)?;
    if runtime.clock().mode == Mode::Realtime
        && let Some(hosted) = controller.law.hosted()
    {
        hosted.begin_realtime(&scenario);
    }
    runtime.run_cycles(|runtime| controller.cycle(runtime))?;
    let report = controller.report(runtime.skipped());
    runtime.finish(report)
}

/// Time inside the law over all processes of a run's controller; none if that was not kept.
pub fn last_law_times(group: &Group) -> Option<Percentiles> {
    let figures = Figures::of(group, Service::Controller);
    figures.latencies(LAW).ok()?.percentiles_us()
}

/// A whole program that takes the controller's place with one law: `main` of `--service
/// controller=PROGRAM`. Its arguments come from the launcher.
pub fn serve(law: &'static Descriptor) -> std::process::ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    runtime::run_service(Service::Controller, &arguments, |joined| run_law(joined, law))
}

struct Loop {
    law: Box<dyn Law>,
    /// Name of the law in results.
    name: String,
    formulation: &'static Formulation,
    planning: Option<PlanningThread>,
    setting: Setting,
    release: controller::Release,
    plan_period_ns: i64,
    deadline_ns: i64,
    fallback_ns: i64,
    inputs: Inputs,
    command: Publisher<Command>,
    diagnostics: Publisher<Diagnostics>,
    output: Output,
    ladder: Ladder,
    plausibility: Plausibility,
    estimate: EgoEstimate,
    account: Account,
    /// The last command came from the ladder, not from the law.
    braked: bool,
    solve: Latencies,
}

impl Loop {
    fn open(
        runtime: &mut Runtime,
        scenario: &Scenario,
        descriptor: &'static Descriptor,
        mut law: Box<dyn Law>,
    ) -> Result<Self, RuntimeError> {
        let period_ns = i64::from(scenario.controller.period_ms.value()) * 1_000_000;
        let release = scenario.controller.release;
        let mut output = Output::default();
        match law.hosted() {
            Some(hosted) => {
                if runtime.turns().is_some() {
                    hosted.share();
                }
                hosted.start().map_err(|e| RuntimeError::Program(e.into()))?;
            }
            // In one thread its code and data come into memory with the first of many runs.
            None if runtime.turns().is_some() => {}
            // Brings its code and data into memory before the loop; then clears it.
            None => law.step(&Input { period_s: 0.1, ..Input::default() }, &mut output),
        }
        law.reset();
        let planning = PlanningThread::start(runtime, law.as_mut(), period_ns)?;
        Ok(Self {
            law,
            name: match std::ptr::eq(descriptor, &EXTERNAL) {
                true => scenario.controller.name.as_str().to_owned(),
                false => descriptor.name.to_owned(),
            },
            formulation: (descriptor.formulation)(&scenario.controller),
            planning,
            setting: Setting::of(scenario, descriptor.measured_target),
            release,
            plan_period_ns: period_ns,
            deadline_ns: i64::from(scenario.controller.deadline().value()) * 1_000_000,
            fallback_ns: (period_ns as f64 * FALLBACK) as i64,
            inputs: Inputs::open(runtime, scenario)?,
            command: runtime.publisher()?,
            diagnostics: runtime.publisher()?,
            output,
            ladder: Ladder::new(scenario),
            plausibility: Plausibility::new(scenario),
            estimate: EgoEstimate::default(),
            account: Account::new(),
            braked: false,
            solve: runtime.figures().latencies(LAW)?,
        })
    }

    fn cycle(&mut self, runtime: &mut Runtime) -> Result<Cycle, RuntimeError> {
        let release = match self.release {
            controller::Release::Radar => {
                runtime.next_release_by(&mut self.inputs.radar, self.fallback_ns)?
            }
            controller::Release::Timer => runtime.next_release(Overrun::Skip)?,
        };
        let Some(release) = release else { return Ok(Cycle::Last) };
        let before = runtime.usage();
        self.inputs.update(runtime)?;
        let header = Header::new(release.step, release.scheduled_ns, self.inputs.origins());
        let (input, admission) = self.decide(&release);
        match admission {
            Admission::Law => self.drive(runtime, &release, &input)?,
            Admission::Brake => {
                let bounds = self.law.request_bounds_mps2();
                self.ladder.brake(&input.ego, self.setting.period_s, bounds, &mut self.output);
            }
            // Send an empty plan: it means "no command". In lockstep the plant waits for a message.
            Admission::Silence => {
                let mode = self.output.mode;
                self.output = Output { mode, plan_len: 0, ..Output::default() };
            }
        }
        self.braked = admission == Admission::Brake;

        let radar = self.inputs.radar.newest();
        let radar_release_ns =
            radar.map_or(-1, |radar| runtime.clock().scheduled_ns(radar.header.step));
        let used = runtime.usage().since(&before);
        let mut command = self.command.loan()?;
        self.write_command(&mut command, header, &release, radar_release_ns, &used);
        // By the command's own stamp, so that a recording repeats it.
        let in_time = self.command.send(command)? - release.scheduled_ns <= self.deadline_ns;
        self.account.deadline_misses += u64::from(!in_time);
        let level = self.ladder.settle(&self.output, in_time);
        let mut diagnostics = self.diagnostics.loan()?;
        self.write_diagnostics(&mut diagnostics, header, &release, level);
        self.diagnostics.send(diagnostics)?;
        if admission == Admission::Law
            && let Some(planning) = &mut self.planning
        {
            planning.after_step(self.law.as_mut(), &release);
        }
        self.account.count(release.time_s, &self.output, level);
        let state =
            if level == Level::Full { ServiceState::Running } else { ServiceState::Degraded };
        runtime.end_cycle(state)?;
        Ok(Cycle::Next)
    }

    /// The law's input, and who drives: as far as the inputs allow.
    fn decide(&mut self, release: &Release) -> (Input, Admission) {
        let time_s = release.time_s;
        let commanded_mps2 = self.output.request_mps2();
        let TrustedInputs { odometry, radar, spat, signals_doubted } = self.plausibility.look(
            self.inputs.odometry.newest(),
            self.inputs.radar.newest(),
            self.inputs.spat.newest(),
            commanded_mps2,
            time_s,
        );
        let age = |acquisition_ns: i64| time_s - acquisition_ns as f64 / 1e9;
        let stale_s = self.ladder.stale_odometry_s;
        let fresh = odometry.filter(|odometry| age(odometry.header.acquisition_ns) <= stale_s);
        let ego = match fresh {
            Some(odometry) => {
                self.estimate.believe(odometry, time_s);
                Some(odometry)
            }
            None => self.estimate.advance(radar, commanded_mps2, time_s),
        };
        let powertrain = self.inputs.powertrain().filter(|powertrain| {
            // The grade is what it shows beyond odometry's acceleration of the same time.
            fresh.is_some() && age(powertrain.header.acquisition_ns) <= stale_s
        });
        let (map, preview) = (self.inputs.map.newest(), self.inputs.preview());
        let motions = self.inputs.motions.as_ref().and_then(Subscriber::newest);
        let samples = Samples { odometry: ego, radar, spat, map, motions, powertrain, preview };
        let ages = Ages {
            odometry_s: ego.map(|odometry| age(odometry.header.acquisition_ns)),
            radar_s: radar.map(|radar| age(radar.header.acquisition_ns)),
            spat_s: spat.map(|spat| age(spat.header.acquisition_ns)),
            ego_is_estimated: fresh.is_none(),
            signals_doubted,
        };
        let trust = self.ladder.look(&ages, time_s);
        let mut input = input(&self.setting, &samples, trust, time_s);
        if let Some(curves) = &mut self.inputs.curves {
            curves.cap(&mut input, commanded_mps2);
        }
        let admission = self.ladder.admit(&mut input, radar);
        (input, admission)
    }

    /// One step of the law, and the only place at which its request is bounded.
    fn drive(
        &mut self,
        runtime: &Runtime,
        release: &Release,
        input: &Input,
    ) -> Result<(), RuntimeError> {
        if self.braked {
            // Its state predates the braking.
            self.law.reset();
        }
        if let Some(planning) = &mut self.planning {
            planning.before_step(self.law.as_mut(), release);
        }
        let begun = monotonic_ns();
        self.step(runtime, release, input)?;
        let in_curves_mps2 =
            self.inputs.curves.as_ref().map_or(f64::INFINITY, CurveTopics::most_mps2);
        self.output.bound_from_above(self.ladder.most_mps2().min(in_curves_mps2));
        self.solve.record_ns(monotonic_ns() - begun);
        Ok(())
    }

    /// Asks the law.
    fn step(
        &mut self,
        runtime: &Runtime,
        release: &Release,
        input: &Input,
    ) -> Result<(), RuntimeError> {
        let Some(hosted) = self.law.hosted() else {
            self.law.step(input, &mut self.output);
            return Ok(());
        };
        let left = match runtime.clock().mode {
            Mode::Lockstep => None,
            Mode::Realtime => {
                let left_ns = release.scheduled_ns + self.deadline_ns - runtime.clock().now_ns();
                Some(Duration::from_nanos(left_ns.max(0).unsigned_abs()))
            }
        };
        hosted
            .step_within(left, input, &mut self.output)
            .map_err(|error| RuntimeError::Program(error.into()))
    }

    fn report(&mut self, skipped: u64) -> ControllerReport {
        ControllerReport {
            deadline_us: self.deadline_ns as f64 / 1e3,
            // A release left out is a deadline missed.
            deadline_misses: self.account.deadline_misses + skipped,
            solve_us: self.solve.percentiles_us(),
            relaxed: self.account.relaxed,
            backup: self.account.backup,
            braked: 0,
            planning: self.planning.as_ref().map(PlanningThread::report),
            law: self.name.clone(),
            program: self.law.hosted().map(|hosted| hosted.report()),
            mode_changes: self.account.mode_changes(self.formulation),
            rungs: self.account.levels.report(),
            checks: self.plausibility.findings.report(),
        }
    }
}
