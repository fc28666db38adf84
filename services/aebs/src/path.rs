//! Which objects are in the ego's way: now, or soon if they keep their lateral motion.

use crate::objects::Object;

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
    /// When `object` is in the way, if it is or will be.
    #[must_use]
    pub fn overlap(&self, object: &Object) -> Option<Overlap> {
        let reach_m = self.half_width_m + object.half_width_m;
        let offset_m = object.lateral.position_m;
        let away_mps = object.lateral.rate_mps * offset_m.signum();
        let moves =
            object.lateral.rate_mps.abs() > self.least_lateral_mps && object.lateral_is_known();
        if offset_m.abs() < reach_m {
            let out_s = if !moves {
                f64::INFINITY
            } else if away_mps > 0.0 {
                (reach_m - offset_m.abs()) / away_mps
            } else {
                // Through the middle and out on the other side.
                (reach_m + offset_m.abs()) / -away_mps
            };
            return Some(Overlap { in_s: 0.0, out_s });
        }
        if !moves || away_mps >= 0.0 {
            return None;
        }
        let in_s = (offset_m.abs() - reach_m) / -away_mps;
        let out_s = (offset_m.abs() + reach_m) / -away_mps;
        (in_s <= self.horizon_s).then_some(Overlap { in_s, out_s })
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
        assert_eq!(PATH.overlap(&object(3.5, 0.0)), None, "beside");
        assert_eq!(PATH.overlap(&object(3.5, 1.0)), None, "going away");
        let ahead = PATH.overlap(&object(0.3, 0.0)).expect("in the way");
        assert_eq!((ahead.in_s, ahead.out_s), (0.0, f64::INFINITY));
        let coming = PATH.overlap(&object(2.9, -1.0)).expect("soon in the way");
        assert!((coming.in_s - 1.0).abs() < 1e-12 && (coming.out_s - 4.8).abs() < 1e-12);
        assert_eq!(PATH.overlap(&object(3.5, -1.0)), None, "later than is believed");
        let mirrored = PATH.overlap(&object(-2.9, 1.0)).expect("soon in the way");
        assert_eq!(mirrored, coming);
    }

    #[test]
    fn a_lateral_speed_within_its_noise_says_nothing() {
        assert_eq!(PATH.overlap(&object(2.0, -0.1)), None);
    }
}
