//! The road ahead by a scan: the slip angle and the course, from objects that stand beside the road.

use messages::{Detection, MAX_DETECTIONS};

use super::association::{Point, Reading};
use super::birth;
use super::course::Course;
use super::course_filter::{CourseFilter, MapAhead, Motion, Sources};
use super::course_numbers::CourseNumbers;
use super::numbers::Numbers;
use super::slip::Slip;
use crate::radar::echo::Antenna;
use crate::radar::receiver::Receiver;

/// Perception's model of the radar.
#[derive(Clone, Copy, Debug)]
pub struct Radar {
    /// Its receiver.
    pub receiver: Receiver,
    /// Its antenna.
    pub antenna: Antenna,
}

impl Radar {
    /// The radar of these keys.
    #[must_use]
    pub fn new(keys: &scenario::perception::Radar, receiver: &Receiver) -> Self {
        let antenna = Antenna::new(
            keys.detections.snr_at_100_m_db.value(),
            keys.detections.edge_loss_db.value(),
            keys.field_of_view_deg.value(),
            keys.max_range_m.value(),
        );
        Self { receiver: *receiver, antenna }
    }

    /// Cross section that makes an echo as strong as this one, m².
    #[must_use]
    pub fn area_m2(&self, detection: &Detection, snr: f64) -> f64 {
        let Detection { range_m, azimuth_rad, .. } = *detection;
        snr / self.antenna.power_of_square_metre(range_m, azimuth_rad)
    }
}

/// The road ahead.
#[derive(Clone, Debug)]
pub struct RoadAhead {
    filter: CourseFilter,
    slip: Slip,
    /// Standing objects: cosine and sine of the azimuth, and range rate, m/s.
    rates: Vec<(f64, f64, f64)>,
    /// Weak ones of them: places in the body's axes, m.
    places: Vec<(f64, f64)>,
}

impl RoadAhead {
    /// Straight on, before the first scan.
    #[must_use]
    pub fn new(sources: Sources, numbers: &CourseNumbers) -> Self {
        Self {
            filter: CourseFilter::new(sources, numbers),
            slip: Slip::default(),
            rates: Vec::with_capacity(MAX_DETECTIONS),
            places: Vec::with_capacity(MAX_DETECTIONS),
        }
    }

    /// The ego's motion as it is known.
    #[must_use]
    pub fn motion(&self, speed_mps: f64, yaw_rate_radps: Option<f64>) -> Motion {
        Motion { speed_mps, yaw_rate_radps, slip_rad: self.slip.slip_rad() }
    }

    /// Moves the course on to this scan and corrects it. Returns it as it was before the correction. Allocates nothing.
    pub fn find(
        &mut self,
        dt_s: f64,
        motion: &Motion,
        map: Option<&MapAhead>,
        (detections, readings): (&[Detection], &[Reading]),
        (radar, numbers): (&Radar, &Numbers),
    ) -> Course {
        self.filter.advance(dt_s, motion);
        let before = *self.filter.course();
        self.rates.clear();
        self.places.clear();
        for (index, (detection, reading)) in detections.iter().zip(readings).enumerate() {
            let read = (detection, reading);
            let point = Point::new(index, read, motion, &radar.receiver, &before);
            if birth::moves(&point, numbers) || point.y_m.abs() < numbers.off_lane_m {
                continue;
            }
            self.rates.push((reading.cosine, reading.sine, detection.range_rate_mps));
            if radar.area_m2(detection, reading.snr) < self.filter.numbers().post_area_m2 {
                self.places.push((reading.ahead_m, reading.left_m));
            }
        }
        self.slip.take_scan(dt_s, motion.speed_mps, &self.rates);
        let motion = Motion { slip_rad: self.slip.slip_rad(), ..*motion };
        self.filter.take(&motion, map, &self.places);
        before
    }

    /// The same without detections: by the ego's motion, the map and the trails.
    pub fn find_blind(&mut self, dt_s: f64, motion: &Motion, map: Option<&MapAhead>) -> Course {
        self.filter.advance(dt_s, motion);
        let before = *self.filter.course();
        self.filter.take(motion, map, &[]);
        before
    }

    /// A vehicle is at a place of the course; see [`CourseFilter::leave_trail`].
    pub fn leave_trail(&mut self, id: u32, place: (f64, f64), lateral_mps: f64) {
        self.filter.leave_trail(id, place, lateral_mps);
    }

    /// The road ahead is estimated at all; otherwise it is straight.
    #[must_use]
    pub fn is_used(&self) -> bool {
        self.filter.is_used()
    }

    /// The course.
    #[must_use]
    pub fn course(&self) -> &Course {
        self.filter.course()
    }

    /// Standard deviation of the course's place across the road at an arc length, m.
    #[must_use]
    pub fn sigma_m(&self, sigma_m: f64) -> f64 {
        self.filter.sigma_m(sigma_m)
    }

    /// The same for the choice of the target; see [`CourseFilter::path_sigma_m`].
    #[must_use]
    pub fn path_sigma_m(&self, sigma_m: f64) -> f64 {
        self.filter.path_sigma_m(sigma_m)
    }

    /// Standard deviation of the course's heading at an arc length, rad.
    #[must_use]
    pub fn heading_sigma_rad(&self, sigma_m: f64) -> f64 {
        self.filter.heading_sigma_rad(sigma_m)
    }

    /// The course as one clothoid; see [`CourseFilter::clothoid`].
    #[must_use]
    pub fn clothoid(&self) -> [f64; 3] {
        self.filter.clothoid()
    }

    /// Standing objects and pairs of trail points that the last scan used.
    #[must_use]
    pub fn used(&self) -> (u32, u32) {
        self.filter.used()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_it_says_is_what_the_filter_says() {
        let trails = Sources { yaw_rate: true, trails: true, ..Sources::default() };
        let mut ahead = RoadAhead::new(trails, &CourseNumbers::DEFAULT);
        let motion = ahead.motion(20.0, Some(0.02));
        for _ in 0..40 {
            let before = *ahead.course();
            assert_ne!(ahead.find_blind(0.05, &motion, None), before, "the ego has moved");
            ahead.leave_trail(7, (60.0, 0.0), 0.0);
        }
        let (posts, pairs) = ahead.used();
        assert_eq!((posts, pairs), (0, 2), "two pairs of the trail");
        assert!(ahead.is_used() && !ahead.course().is_straight());
        assert_eq!(ahead.sigma_m(50.0), ahead.filter.sigma_m(50.0));
        assert!(ahead.sigma_m(50.0) > 0.05 && ahead.sigma_m(100.0) > 2.0 * ahead.sigma_m(50.0));
        assert_eq!(ahead.path_sigma_m(50.0), ahead.sigma_m(50.0));
        assert_eq!(ahead.heading_sigma_rad(50.0), ahead.filter.heading_sigma_rad(50.0));
        assert_eq!(ahead.clothoid(), ahead.filter.clothoid());
        assert!(ahead.clothoid()[1] > 1e-4, "a curve to the left");
    }
}
