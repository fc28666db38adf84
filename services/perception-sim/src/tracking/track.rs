//! One track of a vehicle seen by detections.

use super::abreast::Abreast;
use super::association::{Outline, Point, WIDEST_M};
use super::lateral;
use super::longitudinal::{Filter, Measured, Model, Step};
use super::lost::{LOST_S, Lost, UNSEEN_S};
use super::path::{Across, Approach, Membership};
use crate::radar::scene::Ego;

/// Length and width of a vehicle of which nothing is known yet, m.
const FIRST_LENGTH_M: f64 = 4.5;
const FIRST_WIDTH_M: f64 = 1.8;
/// Longest vehicle, m.
const LONGEST_M: f64 = 25.0;
/// Echoes up to this far behind the nearest one arise at the rear, m.
const REAR_DEPTH_M: f64 = 0.8;
/// Weight of a scan in the extent.
const EXTENT_WEIGHT: f64 = 0.1;
/// Standard deviation of the mean place on the rear and of its mean motion, m and m/s.
const REAR_SIGMA_M: f64 = 0.1;
const REAR_SIGMA_MPS: f64 = 0.02;
/// Standard deviation of an echo from the side, m.
const SIDE_SIGMA_M: f64 = 0.2;
/// Half of the rear that may show no echo before the rest counts as hidden, m.
const SMALL_SLACK_M: f64 = 0.25;
/// Where between the sides the echoes that are not resolved arise: share of a uniform distribution's
/// variance, since the middle is strong.
const MIDDLE_SHARE: f64 = 0.4;
/// A vehicle is cut by the edge of the field of view when it is nearer to it than this, rad.
const EDGE_RAD: f64 = 0.05;
/// A track is begun anew after this many scans in a row that contradict its range.
const MISFITS: u32 = 3;
/// Share of the expected hits from which a track is surely a vehicle.
const FIRM_SHARE: f64 = 0.5;
/// Scans that the history remembers.
const REMEMBERED: u32 = 32;

/// A track.
#[derive(Clone, Copy, Debug)]
pub struct DetectedTrack {
    /// Identity; 0 until it is confirmed.
    pub id: u32,
    /// Motion along the road.
    pub along: Filter,
    /// Motion across the lanes.
    pub across: lateral::Filter,
    /// Whether it is one body, across the lanes.
    pub abreast: Abreast,
    /// Membership of the ego's path.
    pub membership: Membership,
    /// Length as far as it is seen, m.
    pub length_m: f64,
    /// Width as far as it is seen, m.
    pub width_m: f64,
    /// It has been seen moving over ground.
    pub moved: bool,
    /// The detection nearest to the ego in the last scan with any.
    pub nearest: usize,
    /// Time since the last scan with detections of it, s.
    pub unseen_s: f64,
    /// Scans in which it was seen: one bit each, the newest lowest.
    history: u32,
    /// Scans since its beginning, at most [`REMEMBERED`].
    age: u32,
    misfits: u32,
    /// It was seen so often that it is a vehicle.
    is_firm: bool,
    /// Its motion since it was lost in the path.
    lost: Option<Lost>,
}

/// How often a track has to be seen.
#[derive(Clone, Copy, Debug)]
pub struct Life {
    /// Scans with detections ...
    pub hits: u32,
    /// ... of so many in a row confirm a track; one that was never seen moving needs twice as many.
    pub scans: u32,
    /// A confirmed track without detections ends after this time, s.
    pub coast_s: f64,
}

impl Life {
    /// The same for a radar that shows this share of what it should: the fewer the scans that show a vehicle, the
    /// more of them it takes to see it as often.
    #[must_use]
    pub fn with_sight(self, seen_share: f64) -> Self {
        if seen_share >= messages::Sight::LIMITED_BELOW {
            return self;
        }
        let scans = f64::from(self.scans) / seen_share.max(0.1);
        Self { scans: (scans.round() as u32).clamp(self.scans, REMEMBERED), ..self }
    }
}

/// What the radar has before it.
#[derive(Clone, Copy, Debug)]
pub struct FieldOfView {
    /// Half of the opening angle, rad.
    pub half_rad: f64,
    /// Azimuths that are nearer to each other than this may be one, rad.
    pub resolution_rad: f64,
}

impl FieldOfView {
    /// True if a vehicle at this place is well within the field of view.
    #[must_use]
    pub fn surely_shows(&self, gap_m: f64, lateral_m: f64) -> bool {
        gap_m > 1.0 && libm::atan2(lateral_m.abs(), gap_m) < self.half_rad - 2.0 * EDGE_RAD
    }
}

/// What the detections of one vehicle in one scan say together.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sighting {
    count: u32,
    farthest_m: f64,
    nearest: usize,
    range_weight: f64,
    range_moment: f64,
    rate_weight: f64,
    rate_moment: f64,
    right_m: f64,
    left_m: f64,
    rear_count: u32,
    lateral_variance: f64,
    ground_mps: f64,
}

impl Sighting {
    /// Gathers points that belong together; `lateral_mps` is the vehicle's lateral speed.
    #[must_use]
    pub fn of<'a>(
        points: impl Iterator<Item = &'a Point> + Clone,
        lateral_mps: f64,
    ) -> Option<Self> {
        let nearest = points.clone().min_by(|a, b| a.x_m.total_cmp(&b.x_m))?;
        let mut sighting = Self {
            nearest: nearest.detection,
            right_m: f64::INFINITY,
            left_m: f64::NEG_INFINITY,
            ..Self::default()
        };
        for point in points {
            sighting.count += 1;
            sighting.farthest_m = sighting.farthest_m.max(point.x_m);
            sighting.ground_mps += point.ground_speed_mps;
            let weight = 1.0 / point.range_rate_variance;
            sighting.rate_weight += weight;
            sighting.rate_moment += weight * point.relative_speed_mps(lateral_mps);
            let depth_m = REAR_DEPTH_M + 3.0 * point.range_variance.sqrt();
            if point.x_m - nearest.x_m <= depth_m {
                let weight = 1.0 / point.range_variance;
                sighting.range_weight += weight;
                sighting.range_moment += weight * point.x_m;
                sighting.right_m = sighting.right_m.min(point.y_m);
                sighting.left_m = sighting.left_m.max(point.y_m);
                sighting.lateral_variance += point.lateral_variance;
                sighting.rear_count += 1;
            }
        }
        sighting.ground_mps /= f64::from(sighting.count);
        Some(sighting)
    }

    /// Distance of the rear.
    fn range(&self) -> Measured {
        let value = self.range_moment / self.range_weight;
        Measured { value, variance: 1.0 / self.range_weight + REAR_SIGMA_M * REAR_SIGMA_M }
    }

    /// Speed relative to the ego.
    fn relative_speed(&self) -> Measured {
        let value = self.rate_moment / self.rate_weight;
        Measured { value, variance: 1.0 / self.rate_weight + REAR_SIGMA_MPS * REAR_SIGMA_MPS }
    }

    /// Lateral position of the centre of a rear of the given width.
    fn lateral(&self, width_m: f64) -> Measured {
        let count = f64::from(self.rear_count);
        let hidden_m = self.hidden_m(width_m);
        let body = MIDDLE_SHARE * hidden_m * hidden_m / 12.0;
        // The outermost two of several points decide.
        let variance = self.lateral_variance / (count * count.min(2.0)) + body;
        Measured { value: 0.5 * (self.left_m + self.right_m), variance }
    }

    /// How much of a rear of the given width shows no echo, m.
    fn hidden_m(&self, width_m: f64) -> f64 {
        (width_m - (self.left_m - self.right_m)).max(0.0)
    }

    /// Lateral position of the centre of a vehicle of which the inner side is seen.
    fn lateral_by_side(&self, width_m: f64, side: f64) -> Measured {
        let inner_m = if side > 0.0 { self.right_m } else { self.left_m };
        let variance = self.lateral_variance / f64::from(self.rear_count) + SIDE_SIGMA_M.powi(2);
        Measured { value: inner_m + 0.5 * width_m * side, variance }
    }

    /// As [`Self::lateral`], of a rear that the receiver resolves, so that its sides show when nothing
    /// hides them: an echo from part of it agrees with every centre that has it on the rear. `None`
    /// when it agrees with the one that is expected.
    fn lateral_of_part(&self, width_m: f64, expected_m: f64) -> Option<Measured> {
        let whole = self.lateral(width_m);
        let slack_m = 0.5 * self.hidden_m(width_m);
        if slack_m < SMALL_SLACK_M {
            return Some(whole);
        }
        let off_m = whole.value - expected_m;
        let value = expected_m + off_m - off_m.clamp(-slack_m, slack_m);
        (value != expected_m).then_some(Measured { value, ..whole })
    }

    /// Mean speed over ground along the line of sight, m/s.
    #[must_use]
    pub fn ground_mps(&self) -> f64 {
        self.ground_mps
    }
}

impl DetectedTrack {
    /// A track that begins with a sighting.
    #[must_use]
    pub fn begin(model: &Model, sighting: &Sighting, moved: bool) -> Self {
        Self {
            id: 0,
            along: model.start(sighting.range(), sighting.relative_speed()),
            across: lateral::Filter::start(sighting.lateral(FIRST_WIDTH_M)),
            abreast: Abreast::default(),
            membership: Membership::default(),
            length_m: FIRST_LENGTH_M,
            width_m: FIRST_WIDTH_M,
            moved,
            nearest: sighting.nearest,
            unseen_s: 0.0,
            history: 1,
            age: 1,
            misfits: 0,
            is_firm: false,
            lost: None,
        }
    }

    /// Moves the track on to the next scan.
    pub fn predict(&mut self, model: &Model, step: &Step) {
        self.along.predict(model, step);
        self.across.predict(step.dt_s());
        self.unseen_s += step.dt_s();
        self.history <<= 1;
        self.age = (self.age + 1).min(REMEMBERED);
    }

    /// Takes in what this scan showed of the vehicle; returns where it was seen across the lanes.
    pub fn see(
        &mut self,
        model: &Model,
        step: &Step,
        sighting: &Sighting,
        view: &FieldOfView,
    ) -> Measured {
        let seen = sighting.lateral(self.width_m);
        self.unseen_s = 0.0;
        self.history |= 1;
        self.nearest = sighting.nearest;
        let estimate = self.along.estimate();
        let range = sighting.range();
        let range_rate = sighting.relative_speed();
        let ahead_m = range.value - estimate.gap_m;
        let rear_azimuth = libm::atan2(self.across.position_m().abs(), estimate.gap_m);
        let rear_in_view = rear_azimuth < view.half_rad - EDGE_RAD;
        let depth_m = REAR_DEPTH_M + 3.0 * (range.variance + estimate.covariance[0][0]).sqrt();
        if ahead_m > depth_m && ahead_m < self.length_m + 1.0 {
            // The rear is not seen, but the side: it tells of the speed alone.
            self.along.see_range_rate(model, step, range_rate);
            let side = self.across.position_m().signum();
            self.across.update(sighting.lateral_by_side(self.width_m, side));
            self.misfits += u32::from(rear_in_view);
        } else {
            let believed = self.along.update(model, step, range, range_rate);
            let fits = believed.range && believed.range_rate;
            self.misfits = if fits { 0 } else { self.misfits + 1 };
            let cell_m = range.value * view.resolution_rad;
            self.abreast.observe(seen, self.across.position(), cell_m);
            if let Some(lateral) = self.lateral(sighting, range.value, view) {
                self.across.update(lateral);
            }
            self.extend(sighting, range.value);
        }
        if self.misfits >= MISFITS {
            self.along = model.start(range, range_rate);
            self.misfits = 0;
        }
        seen
    }

    /// What a sighting of the rear tells of the lateral position.
    fn lateral(&self, sighting: &Sighting, rear_m: f64, view: &FieldOfView) -> Option<Measured> {
        let lateral_m = self.across.position_m();
        let outer_rad = libm::atan2(lateral_m.abs() + 0.5 * self.width_m, rear_m);
        if outer_rad > view.half_rad - EDGE_RAD {
            return Some(sighting.lateral_by_side(self.width_m, lateral_m.signum()));
        }
        if rear_m * view.resolution_rad < 0.5 * self.width_m {
            return sighting.lateral_of_part(self.width_m, lateral_m);
        }
        Some(sighting.lateral(self.width_m))
    }

    /// Goes on with the motion of a younger track of the same vehicle, if that one is nearer to the rear.
    pub fn take_over(&mut self, younger: &Self) {
        let nearer_m = self.along.estimate().gap_m - younger.along.estimate().gap_m;
        if nearer_m > REAR_DEPTH_M {
            self.along = younger.along;
            self.length_m = (self.length_m + nearer_m).min(LONGEST_M);
            self.misfits = 0;
        }
        self.history |= younger.history & 1;
        if younger.is_seen() {
            self.unseen_s = 0.0;
            self.nearest = younger.nearest;
        }
    }

    fn extend(&mut self, sighting: &Sighting, rear_m: f64) {
        let seen_m = sighting.farthest_m - rear_m;
        if seen_m > self.length_m {
            self.length_m += EXTENT_WEIGHT * (seen_m - self.length_m);
            self.length_m = self.length_m.min(LONGEST_M);
        }
        let seen_m = sighting.left_m - sighting.right_m;
        if seen_m > self.width_m {
            self.width_m += EXTENT_WEIGHT * (seen_m - self.width_m);
            self.width_m = self.width_m.min(WIDEST_M);
        }
    }

    /// The outline for association.
    #[must_use]
    pub fn outline(&self, place: usize) -> Outline {
        let estimate = self.along.estimate();
        let (lateral, speed) = (self.across.position_sigma_m(), self.across.speed_sigma_mps());
        Outline {
            place,
            confirmed: self.id != 0,
            rear_m: estimate.gap_m,
            lateral_m: self.across.position_m(),
            length_m: self.length_m,
            half_width_m: 0.5 * self.width_m,
            relative_speed_mps: estimate.relative_speed_mps,
            lateral_speed_mps: self.across.speed_mps(),
            variances: [
                estimate.covariance[0][0],
                lateral * lateral,
                self.along.range_rate_variance(0.0, self.unseen_s),
                speed * speed,
            ],
        }
    }

    /// Lateral motion.
    #[must_use]
    pub fn across(&self) -> Across {
        Across {
            lateral_m: self.across.position_m(),
            speed_mps: self.across.speed_mps(),
            speed_sigma_mps: self.across.speed_sigma_mps(),
            approach: Approach {
                gap_m: self.along.estimate().gap_m,
                relative_speed_mps: self.along.estimate().relative_speed_mps,
                length_m: self.length_m,
            },
        }
    }

    /// It was seen in this scan.
    #[must_use]
    pub fn is_seen(&self) -> bool {
        self.history & 1 == 1
    }

    /// Carries its motion on while it is not seen in the ego's path, `dt_s` after the scan before. `seen_share` of its
    /// scans show a vehicle.
    pub fn watch(&mut self, dt_s: f64, ego: &Ego, seen_share: f64) {
        let firm_hits = FIRM_SHARE * seen_share * f64::from(REMEMBERED);
        self.is_firm |= self.age == REMEMBERED && f64::from(self.hits(REMEMBERED)) >= firm_hits;
        if self.is_seen() || self.id == 0 || !self.is_firm || !self.membership.in_path() {
            self.lost = None;
        } else if let Some(lost) = &mut self.lost {
            lost.carry_on(dt_s, ego);
        } else {
            let estimate = self.along.estimate();
            self.lost = Some(Lost {
                gap_m: estimate.gap_m,
                speed_mps: (ego.speed_mps + estimate.relative_speed_mps).max(0.0),
                acceleration_mps2: estimate.acceleration_mps2.min(0.0),
            });
        }
    }

    /// Its motion, if it was lost in the path for more than chance misses.
    #[must_use]
    pub fn lost(&self) -> Option<&Lost> {
        self.lost.as_ref().filter(|_| self.unseen_s > UNSEEN_S)
    }

    fn hits(&self, scans: u32) -> u32 {
        let recent = if scans >= REMEMBERED { u32::MAX } else { (1 << scans) - 1 };
        (self.history & recent).count_ones()
    }

    /// It has been seen often enough to be believed.
    #[must_use]
    pub fn deserves_confirmation(&self, life: &Life) -> bool {
        let factor = if self.moved { 1 } else { 2 };
        self.hits(factor * life.scans) >= factor * life.hits
    }

    /// It has not been seen often enough to go on.
    #[must_use]
    pub fn is_over(&self, life: &Life) -> bool {
        if self.id == 0 {
            let factor = if self.moved { 1 } else { 2 };
            let scans = self.age.min(factor * life.scans);
            return scans - self.hits(scans) > factor * (life.scans - life.hits);
        }
        if self.lost.is_some() {
            return self.unseen_s > LOST_S.max(life.coast_s);
        }
        let rarely = self.age == REMEMBERED && self.hits(REMEMBERED) < 2 * life.hits;
        self.unseen_s > life.coast_s + 1e-9 || rarely
    }
}
