//! From the moments of a run to frames, at most ten a second.

use group::{FaultRecord, Moment};
use messages::Diagnostics;
use messages::level::Level;
use runtime::statistics::{Latencies, Percentiles};
use serde::Serialize;
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, TrySendError};
use std::time::{Duration, Instant};

/// Time between two frames.
const PERIOD: Duration = Duration::from_millis(100);
/// Time that all views together get to take the end of the run.
const END_PATIENCE: Duration = Duration::from_millis(500);
/// Most points of the drive in one frame.
const MAX_POINTS: usize = 100;
/// Steps after which there is a point even without news of the other vehicles.
const STEPS: u64 = 10;

/// What is new since the last frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Frame {
    /// Run time reached, s.
    pub time_s: f64,
    /// The drive, in order of time.
    pub points: Vec<Point>,
    /// Mode of the law.
    pub mode: String,
    /// Quality of its last command.
    pub quality: &'static str,
    /// Level of the controller on the degradation ladder.
    pub rung: &'static str,
    /// Radar acquisition to the controller's answer, over the whole run, µs.
    pub answer_us: Option<Percentiles>,
    /// What went wrong since the last frame.
    pub events: Vec<LiveEvent>,
}

/// The drive at an instant. What is not there is null.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Point {
    /// Run time, s.
    pub t_s: f64,
    /// Ego speed, m/s.
    pub speed_mps: f64,
    /// Ego acceleration, m/s².
    pub acceleration_mps2: f64,
    /// Request of the newest command, m/s².
    pub request_mps2: Option<f64>,
    /// Gap to the vehicle ahead, m.
    pub gap_m: Option<f64>,
    /// Its speed, m/s.
    pub lead_speed_mps: Option<f64>,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LiveEvent {
    /// When, s of run time.
    pub t_s: f64,
    /// What.
    pub what: String,
}

/// What a view is told.
#[derive(Clone, Debug)]
pub enum Update {
    /// Something new.
    Frame(Arc<Frame>),
    /// The run is over; how, in a line.
    Ended(Arc<str>),
}

/// Makes frames of a run and hands them to its views. It never waits: a view that does not keep up
/// misses frames.
pub struct LiveFeed {
    modes: &'static [&'static str],
    views: Vec<SyncSender<Update>>,
    due: Instant,
    step: Option<u64>,
    truth_step: Option<u64>,
    cycle_step: Option<u64>,
    faults: usize,
    answers: Latencies,
    last: Point,
    mode: Option<u32>,
    quality: u32,
    level: Level,
}

impl LiveFeed {
    /// A feed for `views` of a law with these modes.
    pub fn new(modes: &'static [&'static str], views: Vec<SyncSender<Update>>) -> Self {
        Self {
            modes,
            views,
            due: Instant::now(),
            step: None,
            truth_step: None,
            cycle_step: None,
            faults: 0,
            answers: Latencies::default(),
            last: Point::default(),
            mode: None,
            quality: 0,
            level: Level::Full,
        }
    }

    /// Looks at the run, which calls this more often than there are frames.
    pub fn look(&mut self, moment: &Moment<'_>) {
        let now = Instant::now();
        if self.views.is_empty() || now < self.due {
            return;
        }
        self.due = now + PERIOD;
        let frame = Arc::new(self.frame(moment));
        self.views.retain(|view| {
            let sent = view.try_send(Update::Frame(Arc::clone(&frame)));
            !matches!(sent, Err(TrySendError::Disconnected(_)))
        });
    }

    /// Tells all views that the run is over, and how.
    pub fn end(self, how: &str) {
        let how: Arc<str> = how.into();
        let begun = Instant::now();
        for view in self.views {
            let mut last = Update::Ended(Arc::clone(&how));
            // A view that does not keep up sees the end of its channel instead.
            while let Err(TrySendError::Full(unsent)) = view.try_send(last)
                && begun.elapsed() < END_PATIENCE
            {
                last = unsent;
                std::thread::sleep(Duration::from_millis(1));
            }
        }
    }

    fn frame(&mut self, moment: &Moment<'_>) -> Frame {
        let (steps, truths, cycles) = moment.drive.heard();
        let first_cycle = cycles.partition_point(|message| {
            self.cycle_step.is_some_and(|last| message.header.step <= last)
        });
        for cycle in &cycles[first_cycle..] {
            self.answers_of(cycle);
            (self.mode, self.quality) = (Some(cycle.mode), cycle.quality);
            self.level = Level::by_number(cycle.rung).unwrap_or(self.level);
        }
        let after = |step: u64| self.step.is_some_and(|last| step <= last);
        let first = steps.partition_point(|ego| after(ego.step));
        let first_truth = truths.partition_point(|message| {
            self.truth_step.is_some_and(|last| message.header.step <= last)
        });
        let mut truths = truths[first_truth..].iter().peekable();
        let mut requests = cycles[first_cycle..].iter().peekable();
        let mut points = Vec::new();
        for ego in &steps[first..] {
            let step = ego.step;
            while let Some(cycle) = requests.next_if(|cycle| cycle.header.step <= step) {
                self.last.request_mps2 = Some(cycle.request_mps2);
            }
            // Where a gap is fresh: in between it would be a staircase.
            let mut fresh = step.is_multiple_of(STEPS);
            while let Some(truth) = truths.next_if(|truth| truth.header.step <= step) {
                self.truth_step = Some(truth.header.step);
                fresh = true;
                let ahead = truth.nearest_ahead(ego.position_m);
                self.last.gap_m = ahead.map(|(gap_m, _)| gap_m);
                self.last.lead_speed_mps = ahead.map(|(_, speed_mps)| speed_mps);
            }
            self.last.t_s = ego.time_s;
            self.last.speed_mps = ego.speed_mps;
            self.last.acceleration_mps2 = ego.acceleration_mps2;
            if fresh {
                points.push(self.last);
            }
        }
        let stride = points.len().div_ceil(MAX_POINTS).max(1);
        let points = points.into_iter().step_by(stride).collect();
        self.step = steps.last().map(|ego| ego.step).or(self.step);
        self.cycle_step = cycles.last().map(|message| message.header.step).or(self.cycle_step);
        let events = moment.faults[self.faults..].iter().map(event).collect();
        self.faults = moment.faults.len();
        Frame {
            time_s: moment.time_ns as f64 / 1e9,
            points,
            mode: self.mode.map_or_else(String::new, |mode| self.mode_name(mode)),
            quality: ["full", "relaxed", "backup", "fall-back"][self.quality.min(3) as usize],
            rung: self.level.name(),
            answer_us: self.answers.percentiles_us(),
            events,
        }
    }

    fn answers_of(&mut self, cycle: &Diagnostics) {
        let radar = cycle.header.origins.radar;
        if radar.is_some() {
            self.answers.record_ns(cycle.header.publish_ns - radar.acquisition_ns);
        }
    }

    fn mode_name(&self, mode: u32) -> String {
        let name = self.modes.get(mode as usize);
        name.map_or_else(|| format!("mode {mode}"), ToString::to_string)
    }
}

fn event(fault: &FaultRecord) -> LiveEvent {
    let whom = fault.service.map(messages::Service::name).or(fault.topic).unwrap_or_default();
    LiveEvent { t_s: fault.t_s, what: format!("{} {whom}", fault.kind).trim_end().to_owned() }
}
