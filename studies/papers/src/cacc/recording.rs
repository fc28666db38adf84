//! Recorded drives of the paper's scenarios, and what is read from them.

use super::Scene;
use crate::runner::Driven;
use supervise::DriveStep;

/// A drive at its control cycles, column by column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    pub time_s: Vec<f64>,
    /// Distance travelled by the ego, m.
    pub position_m: Vec<f64>,
    pub speed_mps: Vec<f64>,
    pub acceleration_mps2: Vec<f64>,
    /// Request that acts from this time on, m/s².
    pub request_mps2: Vec<f64>,
    /// Spacing error `d_s - gap`, m.
    pub gap_error_m: Vec<f64>,
    /// Speed error, ego minus lead, m/s.
    pub speed_error_mps: Vec<f64>,
}

impl Recording {
    /// The control cycles of a drive of the paper's formulation.
    pub fn of(driven: &Driven) -> Self {
        let cycles = || driven.drive.steps.iter().filter(|step| step.figures.is_some());
        let column = |value: fn(&DriveStep) -> f64| cycles().map(value).collect();
        let figure = |name| driven.figure(name).into_iter().map(|(_, value)| value).collect();
        Self {
            time_s: column(|step| step.time_s),
            position_m: column(|step| step.position_m),
            speed_mps: column(|step| step.speed_mps),
            acceleration_mps2: column(|step| step.acceleration_mps2),
            request_mps2: column(|step| step.request_mps2.unwrap_or(f64::NAN)),
            gap_error_m: figure("gap_error_m"),
            speed_error_mps: figure("speed_error_mps"),
        }
    }

    /// Time at which the ego has travelled `line_m`, interpolated between samples, s.
    pub fn crossing_s(&self, line_m: f64) -> Option<f64> {
        crossing(&self.time_s, &self.position_m, line_m)
    }

    /// Position at `time_s`, interpolated between samples, m.
    pub fn position_at_m(&self, time_s: f64) -> Option<f64> {
        crossing(&self.position_m, &self.time_s, time_s)
    }

    /// Total time in `[from_s, to_s)` during which the request satisfies `test`, s.
    pub fn request_time_s(&self, from_s: f64, to_s: f64, test: impl Fn(f64) -> bool) -> f64 {
        let cycles = self.time_s.windows(2).zip(&self.request_mps2);
        let inside = |pair: &[f64]| pair[0] >= from_s - TIE_S && pair[0] < to_s - TIE_S;
        cycles
            .filter(|(pair, u)| inside(pair) && test(**u))
            .map(|(pair, _)| pair[1] - pair[0])
            .sum()
    }

    pub fn requests_mps2(&self, from_s: f64, to_s: f64) -> &[f64] {
        let until = |place_s: f64| self.time_s.partition_point(|t| *t < place_s);
        &self.request_mps2[until(from_s - TIE_S)..until(to_s + TIE_S)]
    }

    /// Time from `from_s` on at which `values` first satisfy `test`, s.
    pub fn first_s(&self, from_s: f64, values: &[f64], test: impl Fn(f64) -> bool) -> Option<f64> {
        let mut cycles = self.time_s.iter().zip(values);
        cycles
            .find(|(time, value)| **time >= from_s - TIE_S && test(**value))
            .map(|(time, _)| *time)
    }

    /// Value at `time_s`, at which there is a cycle.
    pub fn at(&self, time_s: f64, values: &[f64]) -> Option<f64> {
        let i = self.time_s.iter().position(|t| (t - time_s).abs() < TIE_S)?;
        values.get(i).copied()
    }

    /// Time of the first negative request, s.
    pub fn first_negative_s(&self) -> Option<f64> {
        self.first_s(0.0, &self.request_mps2, |u| u < 0.0)
    }

    /// Time from `from_s` on after which the request first rises more than it did before, s.
    pub fn answer_s(&self, from_s: f64) -> Option<f64> {
        let start = self.time_s.iter().position(|t| *t >= from_s - TIE_S)?;
        let rise = |i: usize| self.request_mps2[i] - self.request_mps2[i - 1];
        let before = rise(start.checked_sub(1).filter(|i| *i > 0)?);
        let answers = |i: &usize| rise(*i) > before.max(0.0) + ANSWER_MPS2;
        let answer = (start..self.time_s.len()).find(answers)?;
        Some(self.time_s[answer] - from_s)
    }
}

/// Two times that differ by less are one, s.
const TIE_S: f64 = 1e-9;
/// A request that rises by more than this beyond its course answers the lead, m/s².
const ANSWER_MPS2: f64 = 0.1;

/// Value of `of` where `over`, which rises, reaches `place`; interpolated between samples.
fn crossing(of: &[f64], over: &[f64], place: f64) -> Option<f64> {
    let i = over.iter().position(|&x| x >= place - TIE_S)?;
    if over[i] <= place + TIE_S {
        return of.get(i).copied();
    }
    let before = i.checked_sub(1)?;
    let share = (place - over[before]) / (over[i] - over[before]);
    Some(of[before] + share * (of[i] - of[before]))
}

/// Both laws in the scenes that were driven.
#[derive(Clone, Debug, Default)]
pub struct Runs(pub Vec<(&'static Scene, [Recording; 2])>);

/// A drive as a figure sees it.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    pub scene: &'static Scene,
    pub own: &'a Recording,
    /// The other law's drive in the same scene.
    pub other: &'a Recording,
    /// The same law's drive in scenario A.
    pub in_a: &'a Recording,
}

impl Runs {
    /// The drive of a figure's id, `scene.law.figure`.
    pub fn seen(&self, id: &str) -> Option<Seen<'_>> {
        let mut words = id.split('.');
        let (scene, law) = (words.next()?, usize::from(words.next()? == "cacc"));
        let drives = |scene: &str| self.0.iter().find(|(driven, _)| driven.name == scene);
        let (scene, laws) = drives(scene)?;
        // A figure that needs no other scene can do without A.
        let in_a = &drives("A").map_or(laws, |(_, laws)| laws)[law];
        Some(Seen { scene, own: &laws[law], other: &laws[1 - law], in_a })
    }
}

impl Seen<'_> {
    /// Time at which the ego crosses the line, s.
    pub fn crosses_s(&self) -> Option<f64> {
        self.own.crossing_s(self.scene.line_m)
    }

    /// Distance beyond the line at the switch, m.
    pub fn past_line_m(&self) -> Option<f64> {
        Some(self.own.position_at_m(self.scene.switch_s)? - self.scene.line_m)
    }

    /// Time by which it crosses before the other law, s.
    pub fn earlier_s(&self) -> Option<f64> {
        Some(self.other.crossing_s(self.scene.line_m)? - self.crosses_s()?)
    }

    /// Distance by which it is beyond the other law at the switch, m.
    pub fn farther_m(&self) -> Option<f64> {
        let at_switch_m = |run: &Recording| run.position_at_m(self.scene.switch_s);
        Some(at_switch_m(self.own)? - at_switch_m(self.other)?)
    }
}

pub fn largest(values: &[f64]) -> Option<f64> {
    values.iter().copied().reduce(f64::max)
}

pub fn smallest(values: &[f64]) -> Option<f64> {
    values.iter().copied().reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossing_and_position_interpolate() {
        let t = Recording {
            time_s: vec![0.0, 1.0, 2.0],
            position_m: vec![0.0, 10.0, 30.0],
            ..Recording::default()
        };
        assert_eq!(t.crossing_s(20.0), Some(1.5));
        assert_eq!(t.crossing_s(10.0), Some(1.0));
        assert_eq!(t.crossing_s(31.0), None);
        assert_eq!(t.position_at_m(1.5), Some(20.0));
        assert_eq!(t.position_at_m(2.5), None);
    }
}
