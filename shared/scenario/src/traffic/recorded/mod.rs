//! Recorded motions: a vehicle's speed from a table or a bag.
//!
//! ```text
//! CSV, MCAP ─► rows ─► times and speeds ─► filter ─► cut at the start ─► points
//!            (source)   (columns, bags)    (bags)
//! ```
//!
//! * [`CsvFile`]: the keys of `actors[].profile.csv`
//! * [`read`]: the points of a file, and what was read on the way ([`Record`])
//!
//! A record is refused if it cannot be a motion: a missing column, a time that does not increase, a word instead of a
//! number, a gap. It is noted ([`Record::notes`]) where it asks for more than a car does.

mod columns;
mod keys;
mod source;

pub(crate) use keys::READING;
pub use keys::{AfterEnd, CsvFile};

use crate::quantity::{Speed, Time};
use crate::reading::text_file;
use crate::speeds::SpeedPoint;
use crate::{Problem, Refusal, ScenarioError};
use bags::Motion;
use columns::Columns;
use source::Source;
use std::ops::Range;
use std::path::Path;

/// Longest text of a recorded motion, bytes.
const MAX_RECORD_BYTES: usize = 64 << 20;
/// Columns of a table without the key `columns`.
const USUAL: &str = "t=time_s, v=speed_mps";
/// Most rows of a record.
pub const MAX_ROWS: usize = 500_000;
/// Acceleration beyond which a record is noted, m/s². A car in traffic brakes with less. 6 m/s² is full braking on a
/// wet road, and noise of 0.25 m/s at 10 Hz gives twice as much.
pub const NOTED_MPS2: f64 = 6.0;

/// Deceleration of a vehicle that stops behind the end of its record, m/s²: comfortable braking (chosen).
const STOPPING_MPS2: f64 = 2.0;
/// Lowest speed that a filter still takes as noise at rest, m/s. It is eight times the noise of a usual receiver (0.25
/// m/s). Slower means that the vehicle reverses.
const REST_NOISE_MPS: f64 = -2.0;
/// A record is regular if its 90th percentile of steps is at most twice the median and it has this many rows.
const REGULAR_ROWS: usize = 20;
/// Longest step of a regular record, in median steps, and the least limit, s.
const GAP_STEPS: f64 = 10.0;
const GAP_S: f64 = 1.0;
/// Points of a smoothed record in one half window: closer ones carry nothing more.
const POINTS_PER_HALF: f64 = 10.0;

/// A step that is longer than allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Time of the row before it, s of the run.
    pub from_s: f64,
    pub length_s: f64,
}

/// The content of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Time, s of the run, and speed, m/s, of each row before the filter.
    pub rows: Vec<(f64, f64)>,
    /// Points of the profile, from the start of the run.
    pub points: Vec<SpeedPoint>,
    /// Time at which the vehicle leaves the road, s.
    pub leaves_at_s: Option<Time>,
    /// Median step between two rows, s.
    pub median_step_s: f64,
    /// Steps that are longer than allowed.
    pub gaps: Vec<Gap>,
    /// Stretches that the filter kept at zero, s of the run.
    pub stops: Vec<(f64, f64)>,
    /// The error for the first gap.
    refusal: Option<ScenarioError>,
}

/// Reads the record at `path` as `keys` say.
///
/// ```
/// use scenario::recorded::{CsvFile, read_text};
///
/// let keys = CsvFile { columns: Some("t=stamp:ms, v=speed:km/h".into()), ..CsvFile::default() };
/// let record = read_text("lead.csv", "stamp,speed\n0,36\n500,54\n", &keys)?;
/// assert_eq!(record.rows, [(0.0, 10.0), (0.5, 15.0)]);
/// # Ok::<(), scenario::Refusal>(())
/// ```
///
/// # Errors
/// When the file cannot be read, or a key or a row does not fit.
pub fn read(path: &Path, keys: &CsvFile) -> Result<Record, Refusal> {
    let source = path.display().to_string();
    if bags::is_bag(path) {
        let usual = |text: &str| Columns::parse(text, true);
        let columns = keys.columns.as_deref().map(usual).unwrap_or_else(|| {
            Err(Problem::new("columns", "a bag without columns", "v=FIELD or positions"))
        })?;
        return record(&Source::messages(&source, keys, &columns)?, keys, &columns);
    }
    let text = text_file::read(path, MAX_RECORD_BYTES)
        .map_err(|reason| ScenarioError::whole(&source, reason.to_string()))?;
    read_text(&source, &text, keys)
}

/// Reads a record from the text of a table. `source` stands for it in errors.
///
/// # Errors
/// When a key or a row does not fit.
pub fn read_text(source: &str, text: &str, keys: &CsvFile) -> Result<Record, Refusal> {
    if keys.topic.is_some() {
        let message = format!("{source} is not a bag and has no topics");
        return Err(Problem::new("topic", message, "an MCAP file").into());
    }
    let columns = Columns::parse(keys.columns.as_deref().unwrap_or(USUAL), false)?;
    record(&Source::lines(source, text, keys, &columns)?, keys, &columns)
}

fn record(source: &Source<'_>, keys: &CsvFile, columns: &Columns) -> Result<Record, Refusal> {
    if source.len() > MAX_ROWS {
        let expected = format!("at most {MAX_ROWS}");
        return Err(source.refusal(0, 0, "too many rows", expected).into());
    }
    let t = times(source, columns, keys.offset_s.map(|offset| offset.value()))?;
    let half_s = keys.smooth_s.map(|half| half.value());
    let v = speeds(source, columns, &t, half_s)?;
    let mut steps: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let median_step_s = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let gaps = gaps(&t, longest_step_s(&steps, keys));
    let refusal = gaps.first().map(|(row, gap)| {
        let message = format!("a gap of {:.2} s before this row", gap.length_s);
        let expected =
            format!("steps as the usual {median_step_s:.3} s; max_gap_s allows longer ones");
        source.refusal(*row, 0, &message, expected)
    });
    let (smoothed, standing) = match half_s {
        Some(half_s) => bags::smoothed(&t, &v, half_s),
        None => (v.clone(), Vec::new()),
    };
    let end = |range: &Range<usize>| (t[range.start], t[range.end - 1]);
    let stops = standing.iter().map(end).collect();
    let kept = thinned(&t, &smoothed, &standing, half_s);
    let kept = from_start(kept).ok_or_else(|| {
        let message = format!("the record ends {:.1} s before the run begins", -t[t.len() - 1]);
        Problem::new("offset_s", message, "a time within the record")
    })?;
    let (points, leaves_at_s) = finish(source, kept, keys.after_end)?;
    let rows = t.into_iter().zip(v).collect();
    let gaps = gaps.into_iter().map(|(_, gap)| gap).collect();
    Ok(Record { rows, points, leaves_at_s, median_step_s, gaps, stops, refusal })
}

/// Times of the rows, s of the run.
fn times(
    source: &Source<'_>,
    columns: &Columns,
    mut offset_s: Option<f64>,
) -> Result<Vec<f64>, Refusal> {
    let factor = columns.time.as_ref().map_or(1.0, |time| time.factor);
    let mut first = None;
    let mut times: Vec<f64> = Vec::with_capacity(source.len());
    for row in 0..source.len() {
        let (stamp, is_absolute) = source.stamp(row, factor)?;
        if row == 0 && is_absolute {
            offset_s.get_or_insert(0.0);
        }
        let from = *first.get_or_insert(stamp);
        let time_s = match offset_s {
            Some(offset_s) => factor * (stamp - from) - offset_s,
            None => factor * stamp,
        };
        let is_right = time_s.is_finite() && offset_s.is_some();
        if let Some(refused) = Time::try_from(time_s).err().filter(|_| !is_right) {
            if time_s.is_finite() && row == 0 {
                let message = format!("the time of the first row: {time_s} is out of range");
                let expected = "0 (the run begins with the first row)";
                return Err(Problem::new("offset_s", message, expected).into());
            }
            return Err(source.out_of_range(row, 0, &refused).into());
        }
        if times.last().is_some_and(|last| *last >= time_s) {
            let expected = "a time later than the line before";
            return Err(source.refusal(row, 0, "times must increase", expected).into());
        }
        times.push(time_s);
    }
    Ok(times)
}

fn speeds(
    source: &Source<'_>,
    columns: &Columns,
    t: &[f64],
    half_s: Option<f64>,
) -> Result<Vec<f64>, ScenarioError> {
    let values = |(index, column): (usize, &columns::Column)| {
        let value = |row: usize| {
            let value = source.number(row, index + 1)? * column.factor;
            if value.is_finite() {
                return Ok(value);
            }
            let message = format!("{value} is out of range");
            let expected = match columns.motion {
                Motion::Speed => Speed::RANGE.to_string(),
                _ => "a number".to_owned(),
            };
            Err(source.refusal(row, index + 1, &message, expected))
        };
        (0..t.len()).map(value).collect::<Result<Vec<f64>, _>>()
    };
    let of_motion = columns.of_motion.iter().enumerate().map(values);
    let of_motion = of_motion.collect::<Result<Vec<_>, _>>()?;
    let mut speeds = bags::speeds(t, columns.motion, &of_motion, half_s);
    for (row, speed) in speeds.iter_mut().enumerate() {
        let is_rest = half_s.is_some() && (REST_NOISE_MPS..0.0).contains(speed);
        match Speed::try_from(if is_rest { 0.0 } else { *speed }) {
            Ok(_) => {}
            Err(_) if columns.motion == Motion::Distance && *speed < 0.0 => {
                let expected = "a vehicle that does not reverse";
                return Err(source.refusal(row, 1, "the distance decreases", expected));
            }
            Err(refused) => return Err(source.out_of_range(row, 1, &refused)),
        }
    }
    Ok(speeds)
}

/// Longest step that is not a gap, s. The `steps` are sorted.
fn longest_step_s(steps: &[f64], keys: &CsvFile) -> f64 {
    if let Some(longest) = keys.max_gap_s {
        return longest.value();
    }
    let is_regular = steps.len() + 1 >= REGULAR_ROWS
        && steps[steps.len() * 9 / 10] <= 2.0 * steps[steps.len() / 2];
    // A table that a person writes has the steps that its author needs.
    if is_regular { (GAP_STEPS * steps[steps.len() / 2]).max(GAP_S) } else { f64::INFINITY }
}

/// Gaps with the row behind each.
fn gaps(t: &[f64], longest_s: f64) -> Vec<(usize, Gap)> {
    let gap = |(row, pair): (usize, &[f64])| {
        let (from_s, length_s) = (pair[0], pair[1] - pair[0]);
        (length_s > longest_s).then_some((row + 1, Gap { from_s, length_s }))
    };
    t.windows(2).enumerate().filter_map(gap).collect()
}

/// Rows that a profile needs: all, or a few in each window of a smoothed record, with the ends of stops among them.
fn thinned(t: &[f64], v: &[f64], stops: &[Range<usize>], half_s: Option<f64>) -> Vec<(f64, f64)> {
    let apart_s = half_s.map_or(0.0, |half_s| half_s / POINTS_PER_HALF);
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for i in 0..t.len() {
        let is_end = i + 1 == t.len() || stops.iter().any(|s| s.start == i || s.end == i + 1);
        // Half a sample of slack: the sampling is rarely exact.
        let is_due = kept.last().is_none_or(|last| t[i] - last.0 > 0.999 * apart_s);
        if is_end || is_due {
            kept.push((t[i], v[i].max(0.0)));
        }
    }
    kept
}

/// The points from the start of the run on; `None` if they are all before it.
fn from_start(mut points: Vec<(f64, f64)>) -> Option<Vec<(f64, f64)>> {
    let later = points.iter().position(|point| point.0 >= 0.0)?;
    if later > 0 && points[later].0 > 0.0 {
        let ((t0, v0), (t1, v1)) = (points[later - 1], points[later]);
        points[later - 1] = (0.0, v0 - t0 / (t1 - t0) * (v1 - v0));
        return Some(points.split_off(later - 1));
    }
    Some(points.split_off(later))
}

/// The points of a profile, with the motion behind its end.
fn finish(
    source: &Source<'_>,
    kept: Vec<(f64, f64)>,
    after_end: AfterEnd,
) -> Result<(Vec<SpeedPoint>, Option<Time>), ScenarioError> {
    let last_row = source.len() - 1;
    let time = |time_s: f64| {
        Time::try_from(time_s).map_err(|refused| source.out_of_range(last_row, 0, &refused))
    };
    let mut points = Vec::with_capacity(kept.len() + 1);
    for (time_s, speed_mps) in kept {
        // A line through noisy points can leave the range by a little.
        let speed = Speed::try_from(speed_mps.min(100.0)).expect("finite and not negative");
        points.push(SpeedPoint(time(time_s)?, speed));
    }
    let SpeedPoint(end, speed) = points[points.len() - 1];
    let leaves_at_s = (after_end == AfterEnd::Leave && end.value() > 0.0).then_some(end);
    if after_end == AfterEnd::Stop && speed.value() > 0.0 {
        let stands = time(end.value() + speed.value() / STOPPING_MPS2)?;
        points.push(SpeedPoint(stands, Speed::of(0.0)));
    }
    Ok((points, leaves_at_s))
}

/// The largest change of speed between two points, m/s², with its sign, and its time, s.
pub fn hardest(points: impl IntoIterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    let points: Vec<_> = points.into_iter().collect();
    let change = |pair: &[(f64, f64)]| {
        let ((t0, v0), (t, v)) = (pair[0], pair[1]);
        ((v - v0) / (t - t0), t0)
    };
    let harder = |a: (f64, f64), b: (f64, f64)| if b.0.abs() > a.0.abs() { b } else { a };
    points.windows(2).map(change).reduce(harder)
}

impl Record {
    /// The points of the profile as time, s, and speed, m/s.
    pub fn profile(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.points.iter().map(|point| (point.0.value(), point.1.value()))
    }

    /// Refuses a record with gaps.
    ///
    /// # Errors
    /// With the place of the first gap.
    pub fn expect_whole(&self) -> Result<(), ScenarioError> {
        self.refusal.clone().map_or(Ok(()), Err)
    }

    /// Remarks for the person who uses the record.
    pub fn notes(&self) -> Vec<String> {
        let (rate, at_s) = hardest(self.profile()).unwrap_or_default();
        if rate.abs() <= NOTED_MPS2 {
            return Vec::new();
        }
        vec![format!(
            "it asks for {rate:.1} m/s² at {at_s:.1} s, and a car in traffic for at most {NOTED_MPS2} m/s²: noise or a \
             jump; `smooth_s` filters it"
        )]
    }
}

#[cfg(test)]
mod tests;
