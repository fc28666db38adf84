//! The ego's speed as the radar measures it, by standing objects beside the road.
//!
//! A standing object at azimuth `phi` has the range rate `-v cos(phi)`. So each detection off the ego's lane measures
//! `v`, if it stands. The measurements within reach of the last estimate vote. The reach is the change of speed that a
//! vehicle can make since. The median of the votes is the new estimate. The first scan takes odometry's speed for the
//! last estimate; from then on the two are independent of each other. To contradict odometry takes objects at several
//! places: a vehicle is at one, and traffic moves.
//!
//! Source: D. Kellner, M. Barjenbruch, J. Klappstein, J. Dickmann, K. Dietmayer, Instantaneous ego-motion estimation
//! using Doppler radar, ITSC 2013: the velocity profile of standing targets. It is used without yaw rate and without
//! the search for inliers, which the last estimate replaces.

use super::course::Course;
use super::numbers::Numbers;
use crate::radar::scene::Ego;
use messages::{Detection, MAX_DETECTIONS};

/// A detection's measurement of the ego's speed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Vote {
    speed_mps: f64,
    range_m: f64,
}

#[derive(Clone, Debug)]
pub struct EgoSpeed {
    numbers: Numbers,
    votes: Vec<Vote>,
    /// Room for the ranges of votes, m.
    ranges_m: Vec<f64>,
    /// The last estimate and its time, ns.
    last: Option<(f64, i64)>,
    /// Measurement of the last scan, m/s, and the detections behind it.
    pub measured: Option<(f64, u64)>,
    disagrees: u32,
}

impl EgoSpeed {
    /// No measurement yet.
    pub fn new(numbers: &Numbers) -> Self {
        Self {
            numbers: *numbers,
            votes: Vec::with_capacity(MAX_DETECTIONS),
            ranges_m: Vec::with_capacity(MAX_DETECTIONS),
            last: None,
            measured: None,
            disagrees: 0,
        }
    }

    /// Takes the scan of `time_ns`; `told` is the motion by odometry. Objects off the course are off the lane. Returns
    /// the motion with which the tracker works. It is odometry's, or the measured one where odometry is missing or
    /// contradicts it. Allocates nothing.
    pub fn take_scan(
        &mut self,
        course: &Course,
        time_ns: i64,
        told: Option<Ego>,
        detections: &[Detection],
    ) -> Ego {
        let numbers = self.numbers;
        let reach_mps =
            |elapsed_s: f64| numbers.stand_noise_mps + numbers.ego_change_mps2 * elapsed_s;
        let known = self.last.or_else(|| told.map(|told| (told.speed_mps, time_ns)));
        self.vote(course, told, detections);
        let (near, least) = match known {
            Some((last_mps, then_ns)) => {
                let reach_mps = reach_mps((time_ns - then_ns) as f64 * 1e-9);
                (near(&self.votes, last_mps, reach_mps), numbers.least_points)
            }
            None => (densest(&self.votes, numbers.stand_noise_mps), numbers.least_unbound),
        };
        self.measured = median_mps(near)
            .filter(|_| near.len() >= least as usize)
            .filter(|mps| {
                told.is_none_or(|told| (mps - told.speed_mps).abs() <= numbers.disagrees_mps)
                    || places(near, &mut self.ranges_m, &numbers) >= numbers.least_places
            })
            .map(|mps| (mps.max(0.0), near.len() as u64));
        if let Some((mps, _)) = self.measured {
            self.last = Some((mps, time_ns));
        }
        self.choose(told)
    }

    fn choose(&mut self, told: Option<Ego>) -> Ego {
        let last_mps = self.last.map(|(mps, _)| mps);
        let of_measured = |mps| Ego { speed_mps: mps, ..Ego::default() };
        let Some(told) = told else { return last_mps.map_or(Ego::default(), of_measured) };
        if let Some((mps, _)) = self.measured {
            let differs = (mps - told.speed_mps).abs() > self.numbers.disagrees_mps;
            self.disagrees = if differs { self.disagrees + 1 } else { 0 };
        }
        match last_mps {
            Some(mps) if self.disagrees >= self.numbers.disagrees_scans => of_measured(mps),
            _ => told,
        }
    }

    /// Lists the ego's speeds by detections off the lane, in order. What goes along with a moving ego is traffic.
    fn vote(&mut self, course: &Course, told: Option<Ego>, detections: &[Detection]) {
        self.votes.clear();
        let Numbers { disagrees_mps, stand_noise_mps, .. } = self.numbers;
        let moves = told.is_some_and(|told| told.speed_mps > disagrees_mps + stand_noise_mps);
        for detection in detections {
            let (sine, cosine) = libm::sincos(detection.azimuth_rad);
            let speed_mps = -detection.range_rate_mps / cosine;
            let goes_along = moves && speed_mps.abs() <= stand_noise_mps;
            if goes_along || cosine <= 0.5 || detection.ambiguity_group != 0 {
                continue;
            }
            let Numbers { off_lane_m, off_lane_rad, .. } = self.numbers;
            let lane_m = off_lane_m + off_lane_rad * detection.range_m;
            let off_m = course.locate(detection.range_m * cosine, detection.range_m * sine).d_m;
            if off_m.abs() > lane_m {
                self.votes.push(Vote { speed_mps, range_m: detection.range_m });
            }
        }
        self.votes.sort_unstable_by(|a, b| a.speed_mps.total_cmp(&b.speed_mps));
    }
}

/// The sorted votes within `reach` of `at`.
fn near(votes: &[Vote], at: f64, reach: f64) -> &[Vote] {
    let from = votes.partition_point(|vote| vote.speed_mps < at - reach);
    let to = votes.partition_point(|vote| vote.speed_mps <= at + reach);
    votes.get(from..to).unwrap_or_default()
}

/// The densest window of the sorted votes.
fn densest(votes: &[Vote], reach: f64) -> &[Vote] {
    let around = votes.iter().map(|vote| near(votes, vote.speed_mps, reach));
    around.max_by_key(|near| near.len()).unwrap_or_default()
}

/// The median of sorted votes.
fn median_mps(votes: &[Vote]) -> Option<f64> {
    Some(votes.get(votes.len() / 2)?.speed_mps)
}

/// Places of the objects behind these votes: ranges apart by more than a vehicle's length.
fn places(votes: &[Vote], ranges_m: &mut Vec<f64>, numbers: &Numbers) -> u32 {
    ranges_m.clear();
    ranges_m.extend(votes.iter().map(|vote| vote.range_m));
    ranges_m.sort_unstable_by(f64::total_cmp);
    let mut last_m = f64::NEG_INFINITY;
    let mut count = 0;
    for &range_m in &*ranges_m {
        if range_m - last_m > numbers.place_m {
            (last_m, count) = (range_m, count + 1);
        }
    }
    count
}

#[cfg(test)]
mod tests;
