//! The motion of a car while it drives, for the car behind it, which drives at the same time.
//!
//! Points come in portions, and the car behind waits for the points that it needs next. The given points must be the
//! beginning of the whole motion. A car that ends early may have other points than it gave: then the car behind is
//! driven again.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use group::Moment;
use group::in_process::Ahead;
use runtime::Timetable;
use scenario::Scenario;
use scenario::speeds::SpeedPoint;

use super::motion::{self, Motion};

/// Points that are handed over at once.
const PORTION: usize = 64;

/// A motion on its way from one thread to another.
#[derive(Debug, Default)]
pub struct Growing {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    given: Vec<SpeedPoint>,
    /// The given points are not the beginning of the motion.
    is_revoked: bool,
    end: Option<End>,
}

#[derive(Debug)]
enum End {
    Whole(Motion),
    /// There is no motion: the drive failed or was interrupted.
    Failed,
}

impl Growing {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait_until(&self, is_there: impl Fn(&State) -> bool) -> MutexGuard<'_, State> {
        let going_on = |state: &mut State| !is_there(state);
        self.changed.wait_while(self.state(), going_on).unwrap_or_else(PoisonError::into_inner)
    }

    fn give(&self, portion: &mut Vec<SpeedPoint>) {
        self.state().given.append(portion);
        self.changed.notify_all();
    }

    /// Revokes the points that were given.
    pub fn revoke(&self) {
        self.state().is_revoked = true;
        self.changed.notify_all();
    }

    /// True once the points given are known not to be the motion's.
    pub fn is_revoked(&self) -> bool {
        self.state().is_revoked
    }

    /// The drive is over, and this was its motion.
    pub fn finish(&self, motion: Motion) {
        let mut state = self.state();
        state.is_revoked |= !motion.points().starts_with(&state.given);
        state.end = Some(End::Whole(motion));
        self.changed.notify_all();
    }

    /// The drive is over; without a motion it has failed.
    pub fn close(&self) {
        self.state().end.get_or_insert(End::Failed);
        self.changed.notify_all();
    }

    /// Gives the memory back: the car behind has ended too.
    pub fn forget(&self) {
        *self.state() = State { end: Some(End::Failed), ..State::default() };
    }

    /// Waits for the end of the drive; `None` if it has failed.
    pub fn whole(&self) -> Option<Motion> {
        match &self.wait_until(|state| state.end.is_some()).end {
            Some(End::Whole(motion)) => Some(motion.clone()),
            Some(End::Failed) | None => None,
        }
    }

    /// Waits for the first point; `None` if the drive is over before, or no point counts.
    pub fn start(&self) -> Option<Motion> {
        let state = self
            .wait_until(|state| !state.given.is_empty() || state.is_revoked || state.end.is_some());
        let first = state.given.first().filter(|_| !state.is_revoked && state.end.is_none())?;
        Some(Motion::from_points(vec![*first]))
    }

    /// The points as the run of the car behind takes them.
    pub fn ahead(self: &Arc<Self>) -> Ahead {
        let this = Arc::clone(self);
        Box::new(move |until_s, known| {
            let reaches =
                |points: &[SpeedPoint]| points.last().is_some_and(|last| last.0.value() > until_s);
            let state = this.wait_until(|state| {
                reaches(&state.given) || state.is_revoked || state.end.is_some()
            });
            let all = match &state.end {
                Some(End::Whole(motion)) => motion.points(),
                Some(End::Failed) | None => &state.given,
            };
            // One that was revoked may be shorter.
            known.extend_from_slice(all.get(known.len()..).unwrap_or_default());
        })
    }
}

/// Takes the points of a motion from a drive that goes on.
#[derive(Debug)]
pub struct Giver<'a> {
    growing: &'a Growing,
    stride: usize,
    next: usize,
    portion: Vec<SpeedPoint>,
}

impl<'a> Giver<'a> {
    /// A giver for a drive of `scenario` that reaches its end.
    pub fn new(growing: &'a Growing, scenario: &Scenario) -> Self {
        let steps = Timetable::of(scenario).last_step + 1;
        let stride = motion::stride(usize::try_from(steps).expect("runs are finite"));
        Self { growing, stride, next: 0, portion: Vec::with_capacity(PORTION) }
    }

    /// Gives the new points.
    pub fn watch(&mut self, moment: &Moment<'_>) {
        let (steps, _, _) = moment.drive.heard();
        while let Some(step) = steps.get(self.next) {
            self.portion.push(motion::point(step.time_s, step.speed_mps));
            self.next += self.stride;
        }
        if self.portion.len() >= PORTION {
            self.growing.give(&mut self.portion);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(count: u32) -> Vec<SpeedPoint> {
        (0..count).map(|k| motion::point(f64::from(k), 20.0)).collect()
    }

    #[test]
    fn points_arrive_in_order_and_not_before_they_are_asked_for() {
        let growing = Arc::new(Growing::default());
        std::thread::scope(|scope| {
            let giver = &growing;
            scope.spawn(move || {
                let all = points(500);
                all.chunks(7).for_each(|portion| giver.give(&mut portion.to_vec()));
                giver.finish(Motion::from_points(all));
                giver.close();
            });
            let (mut ahead, mut known) = (growing.ahead(), Vec::new());
            for until in 0..600 {
                ahead(f64::from(until), &mut known);
                let last = known.last().map_or(-1.0, |point| point.0.value());
                assert!(last > f64::from(until) || known.len() == 500, "{until} {last}");
            }
            assert_eq!(known, points(500));
        });
        assert!(!growing.is_revoked());
        assert_eq!(growing.whole(), Some(Motion::from_points(points(500))));
    }

    #[test]
    fn a_motion_that_does_not_begin_with_what_was_given_revokes_it() {
        let growing = Growing::default();
        growing.give(&mut points(10));
        assert!(growing.start().is_some());
        growing.finish(Motion::from_points(points(5)));
        assert!(growing.is_revoked() && growing.start().is_none());
        assert_eq!(growing.whole(), Some(Motion::from_points(points(5))));
    }

    #[test]
    fn a_drive_that_failed_keeps_nothing_waiting() {
        let growing = Arc::new(Growing::default());
        growing.give(&mut points(2));
        growing.close();
        let mut known = Vec::new();
        growing.ahead()(100.0, &mut known);
        assert_eq!((known, growing.whole()), (points(2), None));
    }
}
