//! The part of a run that a view shows: the last minute.

use super::feed::{Frame, Point};
use std::collections::VecDeque;

/// Run time that a view shows, s.
pub const WINDOW_S: f64 = 60.0;

#[derive(Clone, Debug, Default)]
pub struct History {
    pub newest: Frame,
    pub points: VecDeque<Point>,
}

impl History {
    pub fn take(&mut self, mut frame: Frame) {
        self.points.extend(frame.points.drain(..));
        let newest_s = self.points.back().map_or(0.0, |point| point.t_s);
        while self.points.front().is_some_and(|point| point.t_s < newest_s - WINDOW_S) {
            self.points.pop_front();
        }
        self.newest = frame;
    }

    /// A figure over the window, without the instants at which it does not apply.
    pub fn series(&self, value: impl Fn(&Point) -> Option<f64>) -> Vec<(f64, f64)> {
        self.points.iter().filter_map(|point| Some((point.t_s, value(point)?))).collect()
    }

    /// The window, s. It moves once the run is longer.
    pub fn window(&self) -> (f64, f64) {
        let newest_s = self.points.back().map_or(0.0, |point| point.t_s);
        let from = (newest_s - WINDOW_S).max(0.0);
        (from, newest_s.max(from + 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_last_minute_is_kept() {
        let mut history = History::default();
        for second in 0..200 {
            let point = Point { t_s: f64::from(second), ..Point::default() };
            history.take(Frame { points: vec![point], ..Frame::default() });
        }
        assert_eq!(history.points.len(), 61);

        assert_eq!(history.window(), (139.0, 199.0));
        assert!(history.newest.points.is_empty(), "kept once");
    }
}
