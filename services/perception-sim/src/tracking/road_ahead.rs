//! The road ahead by a scan: the slip angle, and the course.
//!
//! The course is the estimate of a filter ([`super::course_filter`]), or the mean of a belief ([`super::belief`]).

use messages::{Detection, MAX_DETECTIONS};

use super::association::{Point, Reading};
use super::belief::Belief;
use super::belief::landmarks::Echo;
use super::birth;
use super::course::Course;
use super::course_filter::{CourseFilter, MapAhead, Motion, Sources};
use super::course_numbers::CourseNumbers;
use super::numbers::Numbers;
use super::slip::Slip;
use crate::radar::echo::Antenna;
use crate::radar::receiver::Receiver;

/// Probability of being in the way below which nothing that stands begins a track.
const UNLIKELY: f64 = 0.1;

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
    way: Way,
    slip: Slip,
    /// Standing objects: cosine and sine of the azimuth, and range rate, m/s.
    rates: Vec<(f64, f64, f64)>,
    /// Their echoes.
    echoes: Vec<Echo>,
    /// Places of the weak ones in the body's axes, m.
    places: Vec<(f64, f64)>,
}

/// Idea of the road ahead.
#[derive(Clone, Debug)]
enum Way {
    Filter(Box<CourseFilter>),
    Belief(Box<Belief>),
}

impl RoadAhead {
    /// Straight on, before the first scan.
    #[must_use]
    pub fn new(sources: Sources, numbers: &CourseNumbers) -> Self {
        // The yaw rate alone makes a circle, without hypotheses.
        let way = match sources.as_belief && sources.looks_ahead() {
            true => Way::Belief(Box::new(Belief::new(sources))),
            false => Way::Filter(Box::new(CourseFilter::new(sources, numbers))),
        };
        Self {
            way,
            slip: Slip::default(),
            rates: Vec::with_capacity(MAX_DETECTIONS),
            echoes: Vec::with_capacity(MAX_DETECTIONS),
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
        self.advance(dt_s, motion);
        let before = *self.course();
        self.rates.clear();
        self.echoes.clear();
        self.places.clear();
        for (index, (detection, reading)) in detections.iter().zip(readings).enumerate() {
            let read = (detection, reading);
            let point = Point::new(index, read, motion, &radar.receiver, &before);
            if birth::moves(&point, numbers) {
                continue;
            }
            let area_m2 = radar.area_m2(detection, reading.snr);
            if matches!(self.way, Way::Belief(_)) {
                self.echoes.push(Echo {
                    x_m: reading.ahead_m,
                    y_m: reading.left_m,
                    sigma_m: point.lateral_variance.sqrt(),
                    area_m2,
                    least_m2: radar.area_m2(detection, radar.receiver.threshold),
                });
            }
            if point.y_m.abs() < numbers.off_lane_m {
                continue;
            }
            self.rates.push((reading.cosine, reading.sine, detection.range_rate_mps));
            if let Way::Filter(filter) = &self.way
                && area_m2 < filter.numbers().post_area_m2
            {
                self.places.push((reading.ahead_m, reading.left_m));
            }
        }
        self.slip.take_scan(dt_s, motion.speed_mps, &self.rates);
        let motion = Motion { slip_rad: self.slip.slip_rad(), ..*motion };
        self.take(&motion, map);
        before
    }

    /// The same without detections: by the ego's motion, the map and the trails.
    pub fn find_blind(&mut self, dt_s: f64, motion: &Motion, map: Option<&MapAhead>) -> Course {
        self.advance(dt_s, motion);
        let before = *self.course();
        self.places.clear();
        self.echoes.clear();
        self.take(motion, map);
        before
    }

    fn advance(&mut self, dt_s: f64, motion: &Motion) {
        match &mut self.way {
            Way::Filter(filter) => filter.advance(dt_s, motion),
            Way::Belief(belief) => belief.advance(dt_s, motion),
        }
    }

    fn take(&mut self, motion: &Motion, map: Option<&MapAhead>) {
        match &mut self.way {
            Way::Filter(filter) => filter.take(motion, map, &self.places),
            Way::Belief(belief) => belief.take(motion, map, &self.echoes),
        }
    }

    /// A vehicle is at a place of the course, and moves across it with this speed.
    pub fn leave_trail(&mut self, id: u32, (sigma_m, d_m): (f64, f64), lateral_mps: f64) {
        match &mut self.way {
            Way::Filter(filter) => filter.leave_trail(id, (sigma_m, d_m), lateral_mps),
            Way::Belief(belief) => {
                let point_m = belief.course().place(sigma_m, d_m);
                belief.leave_trail(id, point_m, lateral_mps);
            }
        }
    }

    /// The road ahead is estimated at all; otherwise it is straight.
    #[must_use]
    pub fn is_used(&self) -> bool {
        match &self.way {
            Way::Filter(filter) => filter.is_used(),
            Way::Belief(_) => true,
        }
    }

    /// The belief; `None` of a filter.
    #[must_use]
    pub fn belief(&self) -> Option<&Belief> {
        match &self.way {
            Way::Belief(belief) => Some(belief),
            Way::Filter(_) => None,
        }
    }

    /// The course.
    #[must_use]
    pub fn course(&self) -> &Course {
        match &self.way {
            Way::Filter(filter) => filter.course(),
            Way::Belief(belief) => belief.course(),
        }
    }

    /// Standard deviation of the course's place across the road at an arc length, m; 0 of the straight path.
    #[must_use]
    pub fn sigma_m(&self, sigma_m: f64) -> f64 {
        match &self.way {
            Way::Filter(filter) => filter.sigma_m(sigma_m),
            Way::Belief(belief) => belief.sigma_m(sigma_m),
        }
    }

    /// The same for the choice of the target; see [`CourseFilter::path_sigma_m`].
    #[must_use]
    pub fn path_sigma_m(&self, sigma_m: f64) -> f64 {
        match &self.way {
            Way::Filter(filter) => filter.path_sigma_m(sigma_m),
            Way::Belief(belief) => belief.sigma_m(sigma_m),
        }
    }

    /// Standard deviation of the course's heading at an arc length, rad.
    #[must_use]
    pub fn heading_sigma_rad(&self, sigma_m: f64) -> f64 {
        match &self.way {
            Way::Filter(filter) => filter.heading_sigma_rad(sigma_m),
            Way::Belief(belief) => belief.heading_sigma_rad(sigma_m),
        }
    }

    /// Probability that an object at a place of the course is in the ego's way; `None` without a belief. The object is known across the road to `sigma_m`, and `width_m` wide.
    #[must_use]
    pub fn in_way(&self, (gap_m, d_m): (f64, f64), sigma_m: f64, width_m: f64) -> Option<f64> {
        let belief = self.belief()?;
        Some(belief.in_way(belief.course().place(gap_m, d_m), sigma_m, width_m))
    }

    /// True if a thing that stands at a place of the course is beside the ego's way.
    #[must_use]
    pub fn is_aside(&self, place: (f64, f64), sigma_m: f64, numbers: &Numbers) -> bool {
        let off_m = place.1.abs() - numbers.standing_half_width_m;
        let is_unlikely = || {
            let in_way = self.in_way(place, sigma_m, numbers.first_width_m);
            in_way.is_none_or(|probability| probability < UNLIKELY)
        };
        off_m > 0.0 && (off_m > 3.0 * self.path_sigma_m(place.0) || is_unlikely())
    }

    /// Heading, rad, curvature, 1/m, and its rate, 1/m², of a clothoid. It begins as the course does, and is at the
    /// same place across the road 100 m ahead.
    #[must_use]
    pub fn clothoid(&self) -> [f64; 3] {
        const FAR_M: f64 = 100.0;
        if let Way::Filter(filter) = &self.way {
            return filter.clothoid();
        }
        let course = self.course();
        let (heading_rad, curvature_perm) = (course.heading_rad(), course.curvature_perm(0.0));
        let bent_m = course.place(FAR_M, 0.0).1 - heading_rad * FAR_M;
        let rate_perm2 =
            (bent_m - 0.5 * curvature_perm * FAR_M * FAR_M) * 6.0 / (FAR_M * FAR_M * FAR_M);
        [heading_rad, curvature_perm, rate_perm2]
    }

    /// Standing objects and pairs of trail points in use.
    #[must_use]
    pub fn used(&self) -> (u32, u32) {
        match &self.way {
            Way::Filter(filter) => filter.used(),
            Way::Belief(belief) => belief.used(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRAILS: Sources =
        Sources { yaw_rate: true, standing: false, trails: true, map: false, as_belief: true };

    #[test]
    fn what_it_says_is_what_the_filter_says() {
        let sources = Sources { as_belief: false, ..TRAILS };
        let mut ahead = RoadAhead::new(sources, &CourseNumbers::DEFAULT);
        let motion = ahead.motion(20.0, Some(0.02));
        for _ in 0..40 {
            let before = *ahead.course();
            assert_ne!(ahead.find_blind(0.05, &motion, None), before, "the ego has moved");
            ahead.leave_trail(7, (60.0, 0.0), 0.0);
        }
        assert_eq!(ahead.used(), (0, 2), "two pairs of the trail");
        let Way::Filter(filter) = &ahead.way else { panic!("a filter") };
        assert!(ahead.is_used() && !ahead.course().is_straight() && ahead.belief().is_none());
        assert_eq!(ahead.sigma_m(50.0), filter.sigma_m(50.0));
        assert!(ahead.sigma_m(50.0) > 0.05 && ahead.sigma_m(100.0) > 2.0 * ahead.sigma_m(50.0));
        assert_eq!(ahead.path_sigma_m(50.0), ahead.sigma_m(50.0));
        assert_eq!(ahead.heading_sigma_rad(50.0), filter.heading_sigma_rad(50.0));
        assert_eq!(ahead.clothoid(), filter.clothoid());
        assert!(ahead.clothoid()[1] > 1e-4, "a curve to the left");
    }

    #[test]
    fn what_it_says_is_what_the_belief_says() {
        let mut ahead = RoadAhead::new(TRAILS, &CourseNumbers::DEFAULT);
        let motion = ahead.motion(20.0, Some(0.06));
        for _ in 0..60 {
            let before = *ahead.course();
            assert_ne!(ahead.find_blind(0.05, &motion, None), before, "the ego has moved");
            ahead.leave_trail(7, (60.0, 0.0), 0.0);
        }
        assert_eq!(ahead.used(), (0, 2), "two pairs of the trail");
        let belief = ahead.belief().expect("it looks ahead");
        assert!(ahead.is_used() && !ahead.course().is_straight());
        assert_eq!(ahead.sigma_m(50.0), belief.sigma_m(50.0));
        assert_eq!(ahead.path_sigma_m(50.0), ahead.sigma_m(50.0));
        assert_eq!(ahead.heading_sigma_rad(50.0), belief.heading_sigma_rad(50.0));
        assert!(ahead.sigma_m(10.0) > 0.05 && ahead.sigma_m(100.0) > 2.0 * ahead.sigma_m(10.0));
        let point_m = ahead.course().place(50.0, 1.0);
        assert_eq!(ahead.in_way((50.0, 1.0), 0.2, 1.8), Some(belief.in_way(point_m, 0.2, 1.8)));
        assert!(ahead.clothoid()[1] > 1e-4, "a curve to the left");
    }

    #[test]
    fn what_stands_is_aside_by_the_lane_or_by_the_belief() {
        let numbers = &Numbers::DEFAULT;
        let straight = RoadAhead::new(Sources::default(), &CourseNumbers::DEFAULT);
        let aside = |d_m: f64| straight.is_aside((60.0, d_m), 0.2, numbers);
        assert!(aside(2.1) && !aside(-1.9) && !straight.is_used());
        assert_eq!((straight.sigma_m(50.0), straight.in_way((50.0, 0.0), 0.1, 1.8)), (0.0, None));
        let mut doubtful = RoadAhead::new(TRAILS, &CourseNumbers::DEFAULT);
        let motion = doubtful.motion(20.0, Some(0.0));
        (0..20).for_each(|_| {
            doubtful.find_blind(0.05, &motion, None);
        });
        assert!(!doubtful.is_aside((100.0, 2.1), 0.2, numbers), "the road may turn there");
        assert!(doubtful.is_aside((15.0, 8.0), 0.2, numbers));
    }
}
