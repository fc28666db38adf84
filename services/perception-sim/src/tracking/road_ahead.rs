//! The road ahead by a scan.
//!
//! The course is that of a belief ([`super::belief`]). Without any source it is straight.

use messages::{Detection, MAX_DETECTIONS};

use super::association::Point;
use super::belief::Belief;
use super::belief::landmarks::Echo;
use super::birth;
use super::course::Course;
use super::motion::Motion;
use super::numbers::Numbers;
use super::sources::{MapAhead, Sources};
use crate::radar::echo::Antenna;
use crate::radar::receiver::{Receiver, snr_of};

/// Probability of being in the way below which nothing that stands begins a track.
const UNLIKELY: f64 = 0.1;

/// Perception's model of the radar.
#[derive(Clone, Copy, Debug)]
pub struct Radar {
    pub receiver: Receiver,
    pub antenna: Antenna,
}

impl Radar {
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
    pub fn area_m2(&self, detection: &Detection, snr: f64) -> f64 {
        let Detection { range_m, azimuth_rad, .. } = *detection;
        snr / self.antenna.power_of_square_metre(range_m, azimuth_rad)
    }
}

#[derive(Clone, Debug)]
pub struct RoadAhead {
    /// `None` without any source: straight on.
    belief: Option<Box<Belief>>,
    /// Echoes of standing objects.
    echoes: Vec<Echo>,
}

impl RoadAhead {
    /// Straight on, before the first scan.
    pub fn new(sources: Sources) -> Self {
        Self {
            belief: (sources != Sources::default()).then(|| Box::new(Belief::new(sources))),
            echoes: Vec::with_capacity(MAX_DETECTIONS),
        }
    }

    /// Moves the course on to this scan and corrects it. Returns it as it was before the correction. Allocates nothing.
    /// The points are those of the detections on a straight road.
    pub fn find(
        &mut self,
        dt_s: f64,
        motion: &Motion,
        map: Option<&MapAhead>,
        (detections, points): (&[Detection], &[Point]),
        (radar, numbers): (&Radar, &Numbers),
    ) -> Course {
        let Some(belief) = &mut self.belief else { return Course::STRAIGHT };
        belief.advance(dt_s, motion);
        let before = *belief.course();
        self.echoes.clear();
        for (detection, point) in detections.iter().zip(points) {
            if birth::moves(&point.on(&before, detection, motion), numbers) {
                continue;
            }
            self.echoes.push(Echo {
                x_m: point.x_m,
                y_m: point.y_m,
                sigma_m: point.lateral_variance.sqrt(),
                area_m2: radar.area_m2(detection, snr_of(detection)),
                least_m2: radar.area_m2(detection, radar.receiver.threshold),
            });
        }
        belief.take(motion, map, &self.echoes);
        before
    }

    /// A vehicle is at a place of the course, and moves across it with this speed.
    pub fn leave_trail(&mut self, id: u32, (sigma_m, d_m): (f64, f64), lateral_mps: f64) {
        if let Some(belief) = &mut self.belief {
            let point_m = belief.course().place(sigma_m, d_m);
            belief.leave_trail(id, point_m, lateral_mps);
        }
    }

    /// The belief; `None` of a straight path and of a circle.
    pub fn belief(&self) -> Option<&Belief> {
        self.belief.as_deref().filter(|belief| belief.looks_ahead())
    }

    pub fn course(&self) -> &Course {
        self.belief.as_deref().map_or(&Course::STRAIGHT, Belief::course)
    }

    /// Standard deviation of the course's place across the road at an arc length, m; 0 of the straight path.
    pub fn sigma_m(&self, sigma_m: f64) -> f64 {
        self.belief.as_deref().map_or(0.0, |belief| belief.sigma_m(sigma_m))
    }

    /// What stands at a place of the course is beside the ego's way.
    pub fn is_aside(&self, place: (f64, f64), sigma_m: f64, numbers: &Numbers) -> bool {
        let off_m = place.1.abs() - numbers.standing_half_width_m;
        let Some(belief) = self.belief() else { return off_m > 0.0 };
        off_m > 3.0 * belief.sigma_m(place.0)
            || off_m > 0.0
                && belief.in_way_at(place, sigma_m, numbers.first_width_m, false) < UNLIKELY
    }

    /// Heading, rad, curvature, 1/m, and its rate, 1/m², of a clothoid. It begins as the course does, and is at the
    /// same place across the road 100 m ahead.
    pub fn clothoid(&self) -> [f64; 3] {
        const FAR_M: f64 = 100.0;
        let course = self.course();
        let (heading_rad, curvature_perm) = (course.heading_rad, course.curvature_perm(0.0));
        let bent_m = course.place(FAR_M, 0.0).1 - heading_rad * FAR_M;
        let rate_perm2 =
            (bent_m - 0.5 * curvature_perm * FAR_M * FAR_M) * 6.0 / (FAR_M * FAR_M * FAR_M);
        [heading_rad, curvature_perm, rate_perm2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radar::detections::DetectionRadar;

    const TRAILS: Sources = Sources { yaw_rate: true, standing: false, trails: true, map: false };

    /// A scan without a detection after 50 ms; returns the course before it.
    fn find_blind(ahead: &mut RoadAhead, motion: &Motion) -> Course {
        let text = "schema_version = 1\nname = \"by-hand\"\nduration_s = 10\n";
        let scenario = scenario::Scenario::parse("by-hand", text).expect("a scenario");
        let receiver = *DetectionRadar::new(&scenario).receiver();
        let radar = Radar::new(&scenario.perception.radar, &receiver);
        ahead.find(0.05, motion, None, (&[], &[]), (&radar, &Numbers::DEFAULT))
    }

    fn motion(yaw_rate_radps: f64) -> Motion {
        Motion { speed_mps: 20.0, yaw_rate_radps: Some(yaw_rate_radps), slip_rad: 0.0 }
    }

    #[test]
    fn what_it_says_is_what_the_belief_says() {
        let mut ahead = RoadAhead::new(TRAILS);
        let motion = motion(0.02);
        for _ in 0..60 {
            let before = *ahead.course();
            assert_ne!(find_blind(&mut ahead, &motion), before, "the ego has moved");
            ahead.leave_trail(7, (60.0, 0.0), 0.0);
        }
        let belief = ahead.belief().expect("it looks ahead");
        assert_eq!(belief.used(), (0, 2), "two pairs of the trail");
        assert!(!ahead.course().is_straight);
        assert_eq!(ahead.sigma_m(50.0), belief.sigma_m(50.0));
        assert!(ahead.sigma_m(10.0) > 0.05 && ahead.sigma_m(100.0) > 2.0 * ahead.sigma_m(10.0));
        let point_m = ahead.course().place(50.0, 1.0);
        assert_eq!(belief.in_way_at((50.0, 1.0), 0.2, 1.8, true), belief.in_way(point_m, 0.2, 1.8));
        assert!(ahead.clothoid()[1] > 1e-4, "a curve to the left");
    }

    #[test]
    fn by_the_yaw_rate_alone_it_is_the_ego_s_circle() {
        let mut ahead = RoadAhead::new(Sources { yaw_rate: true, ..Sources::default() });
        let motion = Motion { speed_mps: 20.0, yaw_rate_radps: Some(0.1), slip_rad: 0.01 };
        (0..100).for_each(|_| {
            find_blind(&mut ahead, &motion);
        });
        assert!((ahead.course().curvature_perm(50.0) - 0.005).abs() < 1e-6);
        assert_eq!(ahead.course().heading_rad, 0.01);
        assert!(ahead.belief().is_none(), "the limits of a straight road select the target");
        assert!((ahead.sigma_m(100.0) - libm::hypot(1.2, 1.5)).abs() < 1e-9);
    }

    #[test]
    fn what_stands_is_aside_by_the_lane_or_by_the_belief() {
        let numbers = &Numbers::DEFAULT;
        let straight = RoadAhead::new(Sources::default());
        let aside = |d_m: f64| straight.is_aside((60.0, d_m), 0.2, numbers);
        assert!(aside(2.1) && !aside(-1.9) && straight.course().is_straight);
        assert!(straight.sigma_m(50.0) == 0.0 && straight.belief().is_none());
        let mut doubtful = RoadAhead::new(TRAILS);
        let motion = motion(0.0);
        (0..20).for_each(|_| {
            find_blind(&mut doubtful, &motion);
        });
        assert!(!doubtful.is_aside((100.0, 2.1), 0.2, numbers), "the road may turn there");
        assert!(doubtful.is_aside((15.0, 8.0), 0.2, numbers));
    }
}
