//! Which objects are in the ego's way: now, or soon if they keep their lateral motion.

use crate::objects::Object;

/// What moves outward does so by less than is estimated, by this many standard deviations.
const LEAVING_SIGMAS: f64 = 2.0;

/// Something leaves once its middle is this far off the ego's axis, m.
const LEAVING_OFFSET_M: f64 = 0.8;

/// The ego's swept path and how far ahead lateral motion is believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// Half of the ego's width, m.
    pub half_width_m: f64,
    /// Longest time over which lateral motion is carried on, s.
    pub horizon_s: f64,
    /// Lateral speed below which nothing is concluded from it, m/s.
    pub least_lateral_mps: f64,
}

/// When an object is in the ego's way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Time until its side passes the ego's side, s; 0 if it has.
    pub in_s: f64,
    /// Time until it is out of the way again, s; infinite if it stays.
    pub out_s: f64,
}

impl Path {
    /// When `object` is in the way, if it is or will be, with its lateral motion as it is estimated
    /// (`sigmas` = 0) or less inward by so many standard deviations. What comes in stays.
    #[must_use]
    pub fn overlap(&self, object: &Object, sigmas: f64) -> Option<Overlap> {
        let reach_m = self.half_width_m + object.half_width_m;
        let lateral = &object.lateral;
        let side = lateral.position_m.signum();
        let inward_mps = -lateral.rate_mps * side;
        let known = object.lateral_is_known();
        let offset_m = lateral.position_m.abs();
        if offset_m < reach_m {
            // The end of a lane change is followed late, and what has come in stays.
            let outward_mps = -inward_mps - LEAVING_SIGMAS * lateral.rate_sigma_mps();
            let far = offset_m > LEAVING_OFFSET_M;
            let leaves = known && far && outward_mps > self.least_lateral_mps;
            let out_s = if leaves { (reach_m - offset_m) / outward_mps } else { f64::INFINITY };
            return Some(Overlap { in_s: 0.0, out_s });
        }
        if !known || inward_mps <= self.least_lateral_mps {
            return None;
        }
        let inward_mps = inward_mps - sigmas * lateral.rate_sigma_mps();
        let offset_m = offset_m + sigmas * lateral.position_sigma_m();
        let in_s = (offset_m - reach_m) / inward_mps;
        (inward_mps > 0.0 && in_s <= self.horizon_s)
            .then_some(Overlap { in_s, out_s: f64::INFINITY })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATH: Path = Path { half_width_m: 0.95, horizon_s: 1.2, least_lateral_mps: 0.2 };

    fn object(offset_m: f64, rate_mps: f64) -> Object {
        Object::at(20.0, -5.0, offset_m, rate_mps, 0.95)
    }

    #[test]
    fn beside_ahead_and_coming_in() {
        let overlap = |offset_m, rate_mps| PATH.overlap(&object(offset_m, rate_mps), 0.0);
        assert_eq!(overlap(3.5, 0.0), None, "beside");
        assert_eq!(overlap(3.5, 1.0), None, "going away");
        let ahead = overlap(0.3, 0.0).expect("in the way");
        assert_eq!((ahead.in_s, ahead.out_s), (0.0, f64::INFINITY));
        let leaving = overlap(0.9, 1.0).expect("in the way");
        assert!(leaving.in_s == 0.0 && (leaving.out_s - 1.0).abs() < 1e-12);
        let coming = overlap(2.9, -1.0).expect("soon in the way");
        assert!((coming.in_s - 1.0).abs() < 1e-12 && coming.out_s == f64::INFINITY);
        assert_eq!(overlap(3.5, -1.0), None, "later than is believed");
        assert_eq!(overlap(-2.9, 1.0), Some(coming), "mirrored");
    }

    #[test]
    fn a_lateral_speed_within_its_noise_says_nothing() {
        assert_eq!(PATH.overlap(&object(2.0, -0.1), 0.0), None);
        // What is vague comes later, or not at all.
        let mut vague = object(2.9, -1.1);
        vague.lateral = crate::filter::Lateral::first(2.9, 0.1);
        vague.lateral.rate_mps = -1.1;
        assert!(PATH.overlap(&vague, 0.0).is_some());
        assert_eq!(PATH.overlap(&vague, 1.0), None);
    }
}
