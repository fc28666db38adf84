//! From the moments of a run to frames, at most ten a second. A frame has all that the view shows.

use messages::level::Level;
use messages::{AllVehicles, Diagnostics};
use report::print;
use runtime::statistics::{Latencies, Percentiles};
use std::collections::VecDeque;
use std::sync::mpsc::SyncSender;
use std::time::{Duration, Instant};
use supervise::{DriveStep, FaultRecord, Moment};

const PERIOD: Duration = Duration::from_millis(100);
/// Run time that a view shows, s.
const WINDOW_S: f64 = 60.0;
/// Most points of the drive in one frame.
const MAX_POINTS: usize = 600;
/// Steps after which there is a point even without a new message about the other vehicles.
const STEPS: u64 = 10;
const EVENTS: usize = 12;

/// State of the run, and the last minute of the drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    pub time_s: f64,
    pub duration_s: f64,
    /// The drive within the window, in order of time.
    pub points: Vec<Point>,
    pub mode: String,
    /// Quality of its last command.
    pub quality: &'static str,
    pub level: &'static str,
    /// Radar acquisition to the controller's answer, over the whole run, µs.
    pub answer_us: Option<Percentiles>,
    /// Newest faults and degradations, in order of time.
    pub events: Vec<LiveEvent>,
}

/// The drive at an instant. A figure that does not apply is null.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    pub t_s: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
    /// Request of the newest command, m/s².
    pub request_mps2: Option<f64>,
    /// Gap to the vehicle ahead, m.
    pub gap_m: Option<f64>,
    pub lead_speed_mps: Option<f64>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct LiveEvent {
    pub t_s: f64,
    /// Name, with effect and end once they are known.
    pub what: String,
}

struct Degradation {
    level: Level,
    from_s: f64,
    to_s: Option<f64>,
}

/// Makes frames of a run and sends them to its view. It never waits: a view that does not keep up
/// misses frames. The view ends with it.
pub struct LiveFeed {
    modes: &'static [&'static str],
    duration_s: f64,
    view: SyncSender<Frame>,
    due: Instant,
    /// Step of the newest cycle that was taken.
    cycle_step: Option<u64>,
    degradations: VecDeque<Degradation>,
    answers: Latencies,
    mode: Option<u32>,
    quality: u32,
    level: Level,
}

impl LiveFeed {
    /// A feed for the `view` of a run of `duration_s` under a law with these modes.
    pub fn new(duration_s: f64, modes: &'static [&'static str], view: SyncSender<Frame>) -> Self {
        Self {
            modes,
            duration_s,
            view,
            due: Instant::now(),
            cycle_step: None,
            degradations: VecDeque::new(),
            answers: Latencies::default(),
            mode: None,
            quality: 0,
            level: Level::Full,
        }
    }

    /// Sends a frame if one is due. The run calls this more often.
    pub fn look(&mut self, moment: &Moment<'_>) {
        let now = Instant::now();
        if now < self.due {
            return;
        }
        self.due = now + PERIOD;
        let frame = self.frame(moment);
        // A view that does not keep up, or that is gone, misses it.
        let _ = self.view.try_send(frame);
    }

    fn frame(&mut self, moment: &Moment<'_>) -> Frame {
        let (steps, truths, cycles) = moment.drive.heard();
        let first_cycle = cycles.partition_point(|message| {
            self.cycle_step.is_some_and(|last| message.header.step <= last)
        });
        for cycle in &cycles[first_cycle..] {
            let radar = cycle.header.origins.radar;
            if radar.is_some() {
                self.answers.record_ns(cycle.header.publish_ns - radar.acquisition_ns);
            }
            (self.mode, self.quality) = (Some(cycle.mode), cycle.quality);
            self.enter(Level::by_number(cycle.rung), cycle.header.publish_ns as f64 / 1e9);
        }
        self.cycle_step = cycles.last().map(|message| message.header.step).or(self.cycle_step);
        Frame {
            time_s: moment.time_ns as f64 / 1e9,
            duration_s: self.duration_s,
            points: points(steps, truths, cycles),
            mode: self.mode.map_or_else(String::new, |mode| {
                let name = self.modes.get(mode as usize);
                name.map_or_else(|| format!("mode {mode}"), ToString::to_string)
            }),
            quality: ["full", "relaxed", "backup", "fall-back"][self.quality.min(3) as usize],
            level: self.level.name(),
            answer_us: self.answers.percentiles_us(),
            events: self.events(moment.faults),
        }
    }

    /// Notes the controller's level at `time_s`.
    fn enter(&mut self, level: Option<Level>, time_s: f64) {
        let Some(level) = level.filter(|level| *level != self.level) else { return };
        if let Some(last) = self.degradations.back_mut() {
            last.to_s.get_or_insert(time_s);
        }
        if level != Level::Full {
            self.degradations.push_back(Degradation { level, from_s: time_s, to_s: None });
        }
        if self.degradations.len() > EVENTS {
            self.degradations.pop_front();
        }
        self.level = level;
    }

    fn events(&self, faults: &[FaultRecord]) -> Vec<LiveEvent> {
        let newest = &faults[faults.len().saturating_sub(EVENTS)..];
        let faults = newest.iter().map(|record| {
            let (name, outcome) = (print::fault_name(record), print::fault_outcome(record));
            let end = if outcome.is_empty() { outcome } else { format!(": {outcome}") };
            LiveEvent { t_s: record.t_s, what: name + &end }
        });
        let degradations = self.degradations.iter().map(|Degradation { level, from_s, to_s }| {
            let end = to_s.map_or_else(String::new, |to_s| format!(" for {:.2} s", to_s - from_s));
            LiveEvent { t_s: *from_s, what: format!("degraded to {}{end}", level.name()) }
        });
        let mut events: Vec<_> = faults.chain(degradations).collect();
        events.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
        events.split_off(events.len().saturating_sub(EVENTS))
    }
}

/// The drive within the window, a point where the gap is new: between two of them it would be a staircase.
fn points(steps: &[DriveStep], truths: &[AllVehicles], cycles: &[Diagnostics]) -> Vec<Point> {
    let newest_s = steps.last().map_or(0.0, |ego| ego.time_s);
    let steps = &steps[steps.partition_point(|ego| ego.time_s < newest_s - WINDOW_S)..];
    let from = steps.first().map_or(0, |ego| ego.step);
    let first_truth = truths.partition_point(|truth| truth.header.step < from);
    let first_cycle = cycles.partition_point(|cycle| cycle.header.step < from);
    let mut truths = truths[first_truth..].iter().peekable();
    let mut cycles = cycles[first_cycle..].iter().peekable();
    let (mut points, mut point) = (Vec::new(), Point::default());
    for ego in steps {
        while let Some(cycle) = cycles.next_if(|cycle| cycle.header.step <= ego.step) {
            point.request_mps2 = Some(cycle.request_mps2);
        }
        let mut is_fresh = ego.step.is_multiple_of(STEPS);
        while let Some(truth) = truths.next_if(|truth| truth.header.step <= ego.step) {
            is_fresh = true;
            let ahead = truth.nearest_ahead(ego.position_m);
            point.gap_m = ahead.map(|(gap_m, _)| gap_m);
            point.lead_speed_mps = ahead.map(|(_, speed_mps)| speed_mps);
        }
        if is_fresh {
            let DriveStep { time_s: t_s, speed_mps, acceleration_mps2, .. } = *ego;
            points.push(Point { t_s, speed_mps, acceleration_mps2, ..point });
        }
    }
    let stride = points.len().div_ceil(MAX_POINTS).max(1);
    points.into_iter().step_by(stride).collect()
}

impl Frame {
    /// A figure over the window, without the instants at which it does not apply.
    pub fn series(&self, value: impl Fn(&Point) -> Option<f64>) -> Vec<(f64, f64)> {
        self.points.iter().filter_map(|point| Some((point.t_s, value(point)?))).collect()
    }

    /// The window, s. It moves once the run is longer.
    pub fn window(&self) -> (f64, f64) {
        let newest_s = self.points.last().map_or(0.0, |point| point.t_s);
        let from = (newest_s - WINDOW_S).max(0.0);
        (from, newest_s.max(from + 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::sync_channel;

    #[test]
    fn a_degradation_is_an_event_with_its_end() {
        let mut feed = LiveFeed::new(20.0, &[], sync_channel(1).0);
        let mut enter = |level, time_s| {
            feed.enter(Some(level), time_s);
            feed.events(&[]).into_iter().map(|event| event.what).collect::<Vec<_>>()
        };
        assert!(enter(Level::Full, 0.0).is_empty());
        let begun = enter(Level::LeadPredicted, 2.0);
        assert_eq!(begun, ["degraded to lead-predicted"]);
        assert_eq!(enter(Level::LeadPredicted, 2.1), begun, "the same level is not news");
        let stopped = enter(Level::StopInLane, 3.0);
        assert_eq!(stopped, ["degraded to lead-predicted for 1.00 s", "degraded to stop-in-lane"]);
        assert_eq!(enter(Level::Full, 5.5)[1], "degraded to stop-in-lane for 2.50 s");
    }

    #[test]
    fn only_the_last_minute_is_shown_in_few_points() {
        let step =
            |step: u64| DriveStep { step, time_s: step as f64 / 100.0, ..DriveStep::default() };
        let steps: Vec<_> = (0..=20_000).map(step).collect();
        let frame = Frame { points: points(&steps, &[], &[]), ..Frame::default() };
        assert_eq!((frame.points.len(), frame.points[0].t_s), (301, 140.0));
        assert_eq!(frame.window(), (140.0, 199.0 + 1.0));
        assert_eq!(Frame::default().window(), (0.0, 1.0));
    }
}
