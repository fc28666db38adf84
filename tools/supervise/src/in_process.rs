//! A lockstep run in the calling thread: the services take turns, and memory carries their messages.
//!
//! The results are those of a group of processes, to the byte. Only the machine between the services is left out:
//! processes, shared memory, files. Faults of processes need processes.

use crate::Error;
use crate::faults::Faults;
use crate::refusal::check_simulated;
use crate::start::processes::for_services;
use crate::start::programs;
use controller::laws::external::Questions;
use drive::log::DriveLog;
use drive::report::ServiceReport;
use drive::{Ended, Exit, GroupOutcome, Moment};
use messages::Service;
use runtime::{Carrier, Entry, FromService, InProcess, Program, Sealing};
use scenario::Scenario;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Work of `service` in its process, or in its turns.
pub fn entry(service: Service) -> Entry {
    macro_rules! run_of {
        ($([$service:ident $krate:ident $about:literal])+) => {
            match service {
                $(Service::$service => $krate::run,)+
            }
        };
    }
    messages::each_service!(run_of)
}

/// Runs `scenario` in simulated time, in this thread.
///
/// # Errors
/// [`UsageError`](crate::UsageError) for faults of processes, [`Error::NotReady`] if a service cannot begin.
pub fn run(scenario: &Scenario) -> Result<GroupOutcome, Error> {
    run_watched(scenario, Sealing::Sealed, &|| false, &mut |_| {})
}

/// The same while `watch` sees it go, until `interrupted` says that it is to end. Unsealed messages have neither CRCs nor
/// digests, for a run that is not compared with another one. All else is the same.
pub fn run_watched(
    scenario: &Scenario,
    sealing: Sealing,
    interrupted: &dyn Fn() -> bool,
    watch: &mut dyn FnMut(&Moment<'_>),
) -> Result<GroupOutcome, Error> {
    let mut run = SteppedRun::begin(scenario, sealing, None)?;
    loop {
        match run.advance()? {
            Advance::Over => return run.finish(),
            Advance::Turn => watch(&run.moment()),
            Advance::Asked => unreachable!("no law of this run asks"),
        }
        if interrupted() {
            run.interrupt();
        }
    }
}

/// Progress of a call of [`SteppedRun::advance`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Advance {
    /// Every service had a turn.
    Turn,
    /// The same, and the law waits for the caller's answer.
    Asked,
    Over,
}

/// A run that goes on by its caller's calls. The caller may be the law.
///
/// ```text
/// begin ─► advance … ─► Asked: question, answer ─► advance … ─► Over ─► finish
/// ```
///
/// ```
/// use controller::laws::external::Questions;
/// use supervise::in_process::{Advance, SteppedRun};
/// use messages::{LawAnswer, LawInput};
/// use runtime::Sealing;
///
/// // A law that keeps a time gap of two seconds, in this thread.
/// fn law(q: &LawInput) -> f64 {
///     let free = 0.4 * (q.set_speed_mps - q.speed_mps);
///     let follow = 0.2 * (q.gap_m - 5.0 - 2.0 * q.speed_mps) + 0.7 * q.relative_speed_mps;
///     if q.has_target == 1 { free.min(follow) } else { free }
/// }
///
/// let options = supervise::ScenarioOptions { duration: Some(5.into()), ..Default::default() };
/// let scenario = supervise::open("following", &options).expect("built in");
/// let questions = Questions::default();
/// let mut run = SteppedRun::begin(&scenario, Sealing::Unsealed, Some(questions.clone()))?;
/// let mut asked = 0;
/// loop {
///     match run.advance()? {
///         Advance::Turn => {}
///         Advance::Asked => {
///             let q = questions.question().expect("it was asked");
///             questions.answer(LawAnswer { request_mps2: law(&q), ..bytemuck::Zeroable::zeroed() });
///             asked += 1;
///         }
///         Advance::Over => break,
///     }
/// }
/// assert_eq!((asked, run.finish()?.ended), (51, supervise::Ended::Orderly), "each 100 ms, both ends included");
/// # Ok::<(), supervise::Error>(())
/// ```
#[derive(Debug)]
pub struct SteppedRun {
    run: InProcess,
    services: Vec<Service>,
    programs: BTreeMap<Service, Program>,
    questions: Option<Questions>,
    log: DriveLog,
    faults: Faults,
    course: Course,
    step_ns: i64,
    ready_after: Duration,
    started: Instant,
}

impl SteppedRun {
    /// Brings the services up to the common start. With `questions` the caller is the law.
    pub fn begin(
        scenario: &Scenario,
        sealing: Sealing,
        questions: Option<Questions>,
    ) -> Result<Self, Error> {
        check_simulated(scenario)?;
        let programs = match &questions {
            Some(_) => BTreeMap::new(),
            None => programs(&BTreeMap::new(), scenario)?,
        };
        let begun = Instant::now();
        let mut run = InProcess::new(scenario, sealing);
        let log = DriveLog::in_process(&run, scenario)?;
        let told = for_services(scenario, false);
        for service in scenario.services() {
            match questions.clone().filter(|_| service == Service::Controller) {
                Some(questions) => {
                    run.start(service, &told, |runtime| controller::run_asked(runtime, questions))?
                }
                None => run.start(service, &told, entry(service))?,
            }
        }
        let mut course = Course::default();
        run.take_turns(&mut |service, said| course.receive(service, said));
        if let Some((service, how)) = course.failed.take() {
            run.abort();
            let what = format!("failed: {how}");
            let foreign = programs.contains_key(&service);
            return Err(Error::NotReady { service, what, foreign });
        }
        let ready_after = begun.elapsed();
        run.begin();
        let step_ns = run.timetable().step_ns;
        Ok(Self {
            run,
            services: scenario.services(),
            programs,
            questions,
            log,
            faults: Faults::of(scenario),
            course,
            step_ns,
            ready_after,
            started: Instant::now(),
        })
    }

    /// Gives every service a turn.
    pub fn advance(&mut self) -> Result<Advance, Error> {
        let course = &mut self.course;
        let alive = self.run.take_turns(&mut |service, said| course.receive(service, said));
        self.log.drain()?;
        if !alive {
            return Ok(Advance::Over);
        }
        if let Some(step) = self.course.stop_after.take() {
            self.run.stop_after(step);
        }
        if self.course.failed.is_some() {
            self.run.abort();
        }
        match &self.questions {
            Some(questions) if questions.is_open() => Ok(Advance::Asked),
            _ => Ok(Advance::Turn),
        }
    }

    /// The run as it is now.
    pub fn moment(&self) -> Moment<'_> {
        let reached = i64::try_from(self.log.reached()).expect("runs are finite");
        Moment {
            time_ns: self.step_ns * reached,
            drive: &self.log,
            faults: &self.faults.log.records,
        }
    }

    /// Ends the run at the services' next turns. A question that is open is not asked any more.
    pub fn interrupt(&mut self) {
        if self.course.failed.is_none() {
            self.course.interrupted = true;
        }
        self.run.abort();
        if let Some(questions) = self.questions.as_ref().filter(|questions| questions.is_open()) {
            questions.fail("the run was interrupted".to_owned());
        }
    }

    /// The results of a run that is over.
    pub fn finish(self) -> Result<GroupOutcome, Error> {
        let Self { services, programs, log, mut faults, course, ready_after, started, .. } = self;
        let ran_for = started.elapsed();
        let messages =
            course.reports.values().flat_map(|report| report.fault_statistics.iter().copied());
        faults.log.count_messages(messages);
        // The ends that the services' processes would have had.
        let exits = services.iter().map(|&service| match &course.failed {
            Some((failed, _)) if *failed == service => (service, Exit::Status(1)),
            _ => (service, Exit::Ok),
        });
        let exits = exits.collect();
        let wrote = course.failed.iter().cloned().collect();
        Ok(GroupOutcome {
            carrier: Carrier::Memory,
            root: PathBuf::new(),
            ended: match course.failed {
                _ if course.interrupted => Ended::Interrupted,
                Some((service, how)) => Ended::Broken { service, how },
                None => Ended::Orderly,
            },
            reports: course.reports,
            exits,
            restarts: services.into_iter().map(|service| (service, 0)).collect(),
            take_overs: BTreeMap::new(),
            standby_costs: BTreeMap::new(),
            heartbeats: BTreeMap::new(),
            faults: faults.log.records,
            drive: log.finish()?,
            ready_after,
            ran_for: ran_for.max(Duration::from_nanos(1)),
            recording: None,
            wrote,
            programs,
        })
    }
}

/// Messages of the services about the run so far.
#[derive(Debug, Default)]
struct Course {
    reports: BTreeMap<Service, ServiceReport>,
    /// The first service that could not go on, and why.
    failed: Option<(Service, String)>,
    /// The plant ended the run in this step.
    stop_after: Option<u64>,
    interrupted: bool,
}

impl Course {
    fn receive(&mut self, service: Service, said: FromService) {
        match said {
            FromService::Ready(_) | FromService::TookOver(_) => {}
            FromService::Report(report) => {
                self.reports.insert(service, *report);
            }
            FromService::Ended(step) => self.stop_after = Some(step),
            FromService::Failed(how) => {
                self.failed.get_or_insert((service, how));
            }
        }
    }
}
