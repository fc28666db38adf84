//! Standing things beside the road or on it, in the plane of dead reckoning.
//!
//! A standing object is met in many scans. Its echoes are gathered into one landmark, whose place is their mean. So an
//! object counts once, however often it is seen.
//!
//! The yaw rate has an offset. It turns all landmarks against the new echoes. Their mean turn corrects the offset.

use libm::sincos;

use super::super::motion::{Frame, Motion};

/// Landmarks at most: what 100 objects a kilometre on each side give within the range, and some false alarms.
pub const MOST: usize = 64;
/// Distance behind the ego at which a landmark is dropped, m. The line does not reach farther back.
const DROPPED_M: f64 = 70.0;
/// Distance along the line of sight within which an echo belongs to a landmark, m: twice the range's resolution.
const ALONG_M: f64 = 1.6;
/// Error of the place that no number of echoes improves, m: dead reckoning, and the object's own size.
const PLACE_M: f64 = 0.15;
/// Share of the turn of the landmarks in a scan that corrects the yaw rate, 1/s. One scan shows their turn to 1 mrad.
/// The offset of 2 mrad/s then settles in 2 s, with an error of 0.2 mrad/s.
const OFFSET_GAIN: f64 = 0.05;
/// Greatest offset of a yaw-rate sensor, rad/s: three standard deviations of 0.1 °/s.
const MOST_OFFSET_RADPS: f64 = 0.0052;
/// Echoes of a landmark from which its place shows the ego's turn.
const SETTLED: f64 = 3.0;

/// An echo of something that stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Echo {
    /// Place in the body's axes, m.
    pub x_m: f64,
    pub y_m: f64,
    /// Standard deviation across the line of sight, m.
    pub sigma_m: f64,
    /// Cross section, m².
    pub area_m2: f64,
    /// Smallest cross section that the receiver shows there, m².
    pub least_m2: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Landmark {
    /// Place in the plane, m.
    pub place_m: (f64, f64),
    /// Sum of the weights of its echoes, 1/m².
    pub weight: f64,
    pub count: f64,
    /// Sum of their cross sections, m².
    pub area_m2: f64,
    /// Smallest cross section that the receiver showed at the nearest echo, m².
    pub least_m2: f64,
    /// Distance of the nearest echo, m.
    pub nearest_m: f64,
    /// Scans since its last echo.
    unseen: u32,
}

#[derive(Clone, Debug)]
pub struct Landmarks {
    pub list: Vec<Landmark>,
    offset_radps: f64,
}

impl Default for Landmarks {
    fn default() -> Self {
        Self { list: Vec::with_capacity(MOST), offset_radps: 0.0 }
    }
}

impl Landmarks {
    /// Yaw rate without the sensor's offset, rad/s.
    pub fn yaw_rate_radps(&self, motion: &Motion) -> Option<f64> {
        motion.yaw_rate_radps.map(|radps| radps - self.offset_radps)
    }

    /// Takes the standing echoes of a scan.
    pub fn take(&mut self, ego: &Frame, echoes: &[Echo]) {
        self.forget(ego);
        let (mut turn, mut information) = (0.0, 0.0);
        for echo in echoes {
            let place_m = ego.placed((echo.x_m, echo.y_m));
            let range_m = libm::hypot(echo.x_m, echo.y_m).max(1.0);
            let sigma_m = echo.sigma_m + PLACE_M;
            let weight = 1.0 / (sigma_m * sigma_m);
            let Some((index, across_m)) = self.nearest(ego, (echo.x_m, echo.y_m), echo.sigma_m)
            else {
                self.begin(Landmark {
                    place_m,
                    weight,
                    count: 1.0,
                    area_m2: echo.area_m2,
                    least_m2: echo.least_m2,
                    nearest_m: range_m,
                    unseen: 0,
                });
                continue;
            };
            let landmark = &mut self.list[index];
            if landmark.count >= SETTLED {
                let variance = (1.0 / weight + 1.0 / landmark.weight) / (range_m * range_m);
                turn += across_m / range_m / variance;
                information += 1.0 / variance;
            }
            let share = weight / (landmark.weight + weight);
            landmark.place_m.0 += share * (place_m.0 - landmark.place_m.0);
            landmark.place_m.1 += share * (place_m.1 - landmark.place_m.1);
            landmark.weight += weight;
            landmark.count += 1.0;
            landmark.area_m2 += echo.area_m2;
            if range_m < landmark.nearest_m {
                (landmark.nearest_m, landmark.least_m2) = (range_m, echo.least_m2);
            }
            landmark.unseen = 0;
        }
        if information > 0.0 {
            // New echoes to the left of their landmarks: the ego has turned less than it was said to.
            let offset_radps = self.offset_radps + OFFSET_GAIN * turn / information;
            self.offset_radps = offset_radps.clamp(-MOST_OFFSET_RADPS, MOST_OFFSET_RADPS);
        }
    }

    /// The landmark nearest to a point of the body's axes, and its distance across the line of sight, m.
    fn nearest(&self, ego: &Frame, point_m: (f64, f64), sigma_m: f64) -> Option<(usize, f64)> {
        let place_m = ego.placed(point_m);
        let (sine, cosine) = sincos(ego.heading_rad);
        let range_m = libm::hypot(point_m.0, point_m.1).max(1.0);
        let sight = (
            (point_m.0 * cosine - point_m.1 * sine) / range_m,
            (point_m.0 * sine + point_m.1 * cosine) / range_m,
        );
        let reach_m = 3.0 * (sigma_m + PLACE_M) + 0.5;
        let (mut least, mut nearest) = (1.0, None);
        for (index, landmark) in self.list.iter().enumerate() {
            let (dx, dy) = (place_m.0 - landmark.place_m.0, place_m.1 - landmark.place_m.1);
            let (along_m, across_m) = (dx * sight.0 + dy * sight.1, dy * sight.0 - dx * sight.1);
            let far = (along_m.abs() / ALONG_M).max(across_m.abs() / reach_m);
            if far < least {
                (least, nearest) = (far, Some((index, across_m)));
            }
        }
        nearest
    }

    /// Drops what is behind, and single echoes that do not come again.
    fn forget(&mut self, ego: &Frame) {
        const SINGLE_SCANS: u32 = 20;
        self.list.retain_mut(|landmark| {
            landmark.unseen += 1;
            let is_single = landmark.count < 2.0 && landmark.unseen > SINGLE_SCANS;
            !is_single && ego.seen(landmark.place_m).0 > -DROPPED_M
        });
    }

    /// A new landmark; without room it replaces a single echo.
    fn begin(&mut self, landmark: Landmark) {
        if self.list.len() < MOST {
            self.list.push(landmark);
        } else if let Some(single) = self.list.iter_mut().find(|known| known.count < 2.0) {
            *single = landmark;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT_S: f64 = 0.05;

    /// Echoes of posts on a straight road at 20 m/s, by an ego whose sensor has an offset.
    fn drive(scans: u32, offset_radps: f64) -> (Frame, Landmarks) {
        let (mut ego, mut landmarks) = (Frame::default(), Landmarks::default());
        let motion = Motion { speed_mps: 20.0, yaw_rate_radps: Some(offset_radps), slip_rad: 0.0 };
        for scan in 0..scans {
            let turn_rad = landmarks.yaw_rate_radps(&motion).expect("a yaw rate") * DT_S;
            ego.advance(DT_S, &motion, turn_rad);
            let ego_m = f64::from(scan + 1) * 20.0 * DT_S;
            let echoes: Vec<Echo> = (0..40)
                .map(|post| {
                    (f64::from(post) * 12.0 - ego_m, if post % 2 == 0 { 9.0 } else { -9.0 })
                })
                .filter(|(x_m, _)| (10.0..120.0).contains(x_m))
                .map(|(x_m, y_m)| Echo { x_m, y_m, sigma_m: 0.1, area_m2: 1.0, least_m2: 0.1 })
                .collect();
            landmarks.take(&ego, &echoes);
        }
        (ego, landmarks)
    }

    #[test]
    fn an_object_is_one_landmark_however_often_it_is_seen() {
        let (_, landmarks) = drive(60, 0.0);
        let ahead = landmarks.list.iter().filter(|mark| mark.place_m.0 > 71.0).count();
        assert_eq!(ahead, 9, "one for each post from 72 to 168 m");
        let first = landmarks.list.iter().find(|mark| mark.place_m.0 > 71.0).expect("a post");
        assert!((first.place_m.0 - 72.0).abs() < 1e-6 && first.count == 60.0, "{first:?}");
        assert!((first.nearest_m - libm::hypot(12.0, 9.0)).abs() < 0.01);
    }

    #[test]
    fn landmarks_correct_the_offset_of_the_yaw_rate() {
        let (ego, landmarks) = drive(200, 0.002);
        assert!((landmarks.offset_radps - 0.002).abs() < 4e-4, "{}", landmarks.offset_radps);
        assert!(landmarks.list.iter().all(|mark| ego.seen(mark.place_m).0 > -71.1));
    }

    #[test]
    fn a_single_echo_is_forgotten() {
        let (ego, mut landmarks) = (Frame::default(), Landmarks::default());
        landmarks.take(&ego, &[Echo { x_m: 50.0, sigma_m: 0.2, ..Echo::default() }]);
        for _ in 0..21 {
            assert_eq!(landmarks.list.len(), 1);
            landmarks.take(&ego, &[]);
        }
        assert!(landmarks.list.is_empty());
    }
}
