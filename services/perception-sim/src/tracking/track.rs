//! One track of a vehicle seen by detections.

use super::abreast::Abreast;
use super::association::Outline;
use super::course::Course;
use super::lateral;
use super::longitudinal::{Filter, Measured, Model, Step};
use super::numbers::Numbers;
use super::path::{Across, Approach, COMFORT_MPS2, Membership};
use super::sighting::Sighting;

/// Scans in the history.
const REMEMBERED: u32 = 32;

#[derive(Clone, Copy, Debug)]
pub struct DetectedTrack {
    /// Identity; 0 until it is confirmed.
    pub id: u32,
    /// Its vehicle, if the radar knows it.
    pub vehicle: Option<usize>,
    /// Motion along the road.
    pub along: Filter,
    /// Motion across the lanes.
    pub across: lateral::Filter,
    /// Evidence that it is one body across the lanes.
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
}

/// Hits that a track needs.
#[derive(Clone, Copy, Debug)]
pub struct Life {
    /// Scans with detections ...
    pub hits: u32,
    /// ... of this number of scans in a row confirm a track; a track that never moved needs twice as many.
    pub scans: u32,
    /// A confirmed track without detections ends after this time, s.
    pub coast_s: f64,
}

impl Life {
    /// The same for a radar that shows this share of its usual detections. Fewer scans show a vehicle, so it takes more
    /// of them to see it as often.
    pub fn with_sight(self, seen_share: f64) -> Self {
        if seen_share >= messages::Sight::LIMITED_BELOW {
            return self;
        }
        let scans = f64::from(self.scans) / seen_share.max(0.1);
        Self { scans: (scans.round() as u32).clamp(self.scans, REMEMBERED), ..self }
    }
}

/// The radar's field of view.
#[derive(Clone, Copy, Debug)]
pub struct FieldOfView {
    /// Half of the opening angle, rad.
    pub half_rad: f64,
    /// Azimuths that are nearer to each other than this may be one, rad.
    pub resolution_rad: f64,
    /// Margin to its edge within which a vehicle is cut off, rad.
    pub edge_rad: f64,
}

impl FieldOfView {
    /// True if a place is well within the field of view.
    pub fn shows(&self, x_m: f64, y_m: f64) -> bool {
        x_m > 1.0 && libm::atan2(y_m.abs(), x_m) < self.half_rad - self.edge_rad
    }
}

impl DetectedTrack {
    /// A track that begins with a sighting.
    pub fn begin(model: &Model, sighting: &Sighting, moved: bool) -> Self {
        let numbers = model.numbers();
        let (range, rate) = (sighting.range(numbers), sighting.relative_speed());
        let lateral = sighting.lateral(numbers.first_width_m, numbers);
        Self {
            id: 0,
            vehicle: sighting.vehicle,
            along: model.start(range, rate),
            across: lateral::Filter::start(lateral, numbers),
            abreast: Abreast::default(),
            membership: Membership::default(),
            length_m: numbers.first_length_m,
            width_m: numbers.first_width_m,
            moved,
            nearest: sighting.nearest,
            unseen_s: 0.0,
            history: 1,
            age: 1,
            misfits: 0,
        }
    }

    /// Moves the track on to the next scan.
    pub fn predict(&mut self, model: &Model, step: &Step) {
        match self.is_lost(model.numbers()) {
            true => self.along.carry_on(model, step),
            false => self.along.predict(model, step),
        }
        self.across.predict(step.dt_s, model.numbers());
        self.unseen_s += step.dt_s;
        self.history <<= 1;
        self.age = (self.age + 1).min(REMEMBERED);
    }

    /// Takes in what this scan showed of the vehicle; returns where it was seen across the lanes.
    pub fn see(
        &mut self,
        model: &Model,
        sighting: &Sighting,
        (view, course): (&FieldOfView, &Course),
    ) -> Measured {
        let numbers = model.numbers();
        let seen = sighting.lateral(self.width_m, numbers);
        self.unseen_s = 0.0;
        self.observe_motion(sighting.ground_mps.abs(), numbers);
        self.history |= 1;
        self.nearest = sighting.nearest;
        let (range, range_rate) = (sighting.range(numbers), sighting.relative_speed());
        let (x_m, y_m) = course.place(range.value, self.across.position_m());
        let fits = self.along.update(model, range, range_rate);
        self.misfits = if fits { 0 } else { self.misfits + 1 };
        let cell_m = range.value * view.resolution_rad;
        self.abreast.observe(seen, self.across.position(), cell_m);
        // The edge of the field of view cuts off the side that is farther out.
        let is_cut_off = !view.shows(x_m, y_m.abs() + 0.5 * self.width_m);
        let inner = || sighting.lateral_by_side(self.width_m, y_m.signum(), numbers);
        self.across.update(if is_cut_off { inner() } else { seen }, numbers);
        self.extend(sighting, range.value, numbers);
        if self.misfits >= numbers.misfits {
            self.along = model.start(range, range_rate);
            self.misfits = 0;
        }
        seen
    }

    /// Takes its speed over ground in this scan. One echo that moves may be noise. A new track counts as moving while
    /// all its echoes move, at half of the speed from which one begins.
    pub fn observe_motion(&mut self, ground_mps: f64, numbers: &Numbers) {
        if self.id == 0 {
            self.moved &= ground_mps > 0.5 * numbers.standing_mps;
        } else {
            self.moved |= ground_mps > numbers.standing_mps;
        }
    }

    /// It is not confirmed, and has stood so far.
    pub fn has_stood(&self) -> bool {
        self.id == 0 && !self.moved
    }

    /// Its place on the course: arc length of the rear and distance to the left, m.
    pub fn place(&self) -> (f64, f64) {
        (self.along.estimate().gap_m, self.across.position_m())
    }

    /// Takes over the motion of a younger track of the same vehicle. That one must be nearer to the rear, or be seen
    /// while this one is not.
    pub fn take_over(&mut self, younger: &Self, numbers: &Numbers) {
        let nearer_m = self.along.estimate().gap_m - younger.along.estimate().gap_m;
        let is_unseen = self.unseen_s > 0.0;
        if nearer_m > numbers.rear_depth_m && !is_unseen {
            self.length_m = (self.length_m + nearer_m).min(numbers.longest_m);
        }
        if nearer_m > numbers.rear_depth_m || is_unseen {
            self.along = younger.along;
            self.misfits = 0;
        }
        self.history |= younger.history & 1;
        if younger.is_seen() {
            self.unseen_s = 0.0;
            self.nearest = younger.nearest;
        }
    }

    fn extend(&mut self, sighting: &Sighting, rear_m: f64, numbers: &Numbers) {
        let seen_m = sighting.farthest_m - rear_m;
        if seen_m > self.length_m {
            self.length_m += numbers.extent_weight * (seen_m - self.length_m);
            self.length_m = self.length_m.min(numbers.longest_m);
        }
        let seen_m = sighting.left_m - sighting.right_m;
        if seen_m > self.width_m {
            self.width_m += numbers.extent_weight * (seen_m - self.width_m);
            self.width_m = self.width_m.min(numbers.widest_m);
        }
    }

    /// Lateral position in the axes of the course at its rear, seen from the radar, m. Its sign gives the side that
    /// shows.
    pub fn aspect_m(&self, course: &Course) -> f64 {
        let (gap_m, lateral_m) = self.place();
        let ((x_m, y_m), (cosine, sine)) = (course.place(gap_m, lateral_m), course.tangent(gap_m));
        y_m * cosine - x_m * sine
    }

    /// Stays where it is in the plane while the course under it is corrected.
    pub fn shift(&mut self, before: &Course, after: &Course) {
        let lateral_m = self.across.position_m();
        let (x_m, y_m) = before.place(self.along.estimate().gap_m, lateral_m);
        self.across.shift(after.locate(x_m, y_m).d_m - lateral_m);
    }

    /// The outline for association.
    pub fn outline(&self, course: &Course) -> Outline {
        let estimate = self.along.estimate();
        let (lateral, speed) = (self.across.position_sigma_m(), self.across.speed_sigma_mps());
        Outline {
            vehicle: self.vehicle,
            confirmed: self.id != 0,
            rear_m: estimate.gap_m,
            lateral_m: self.across.position_m(),
            aspect_m: self.aspect_m(course),
            length_m: self.length_m,
            half_width_m: 0.5 * self.width_m,
            relative_speed_mps: estimate.relative_speed_mps,
            lateral_speed_mps: self.across.speed_mps(),
            variances: [
                estimate.covariance[0][0],
                lateral * lateral,
                self.along.range_rate_variance(),
                speed * speed,
            ],
        }
    }

    /// Place and motion across the lanes. The place of what may be several bodies is unknown while there is time to find
    /// out: the middle of two is not a vehicle.
    pub fn across(&self) -> Across {
        let estimate = self.along.estimate();
        let approach =
            Approach { gap_m: estimate.gap_m, relative_speed_mps: estimate.relative_speed_mps };
        if !self.abreast.is_one() && approach.braking_mps2() < COMFORT_MPS2 {
            return Across::resting(f64::INFINITY);
        }
        Across {
            speed_mps: self.across.speed_mps(),
            speed_sigma_mps: self.across.speed_sigma_mps(),
            has_moved: self.moved,
            approach,
            ..Across::resting(self.across.position_m())
        }
    }

    pub fn is_seen(&self) -> bool {
        self.history & 1 == 1
    }

    /// It was lost in the ego's path, for more than chance misses. A short one may be noise: nothing is to be carried on.
    pub fn is_lost(&self, numbers: &Numbers) -> bool {
        self.id != 0
            && self.age == REMEMBERED
            && self.unseen_s > numbers.chance_s
            && self.membership.in_path()
    }

    fn hits(&self, scans: u32) -> u32 {
        let recent = if scans >= REMEMBERED { u32::MAX } else { (1 << scans) - 1 };
        (self.history & recent).count_ones()
    }

    /// It has the hits for its confirmation.
    pub fn deserves_confirmation(&self, life: &Life) -> bool {
        let factor = if self.moved { 1 } else { 2 };
        self.hits(factor * life.scans) >= factor * life.hits
    }

    /// It has not been seen often enough to go on.
    pub fn is_over(&self, life: &Life, numbers: &Numbers) -> bool {
        if self.id == 0 {
            let factor = if self.moved { 1 } else { 2 };
            let scans = self.age.min(factor * life.scans);
            return scans - self.hits(scans) > factor * (life.scans - life.hits);
        }
        if self.is_lost(numbers) {
            return self.unseen_s > numbers.lost_s.max(life.coast_s);
        }
        let rarely = self.age == REMEMBERED && self.hits(REMEMBERED) < 2 * life.hits;
        self.unseen_s > life.coast_s + 1e-9 || rarely
    }
}

#[cfg(test)]
mod tests;
