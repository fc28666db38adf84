//! Objects beside the road: posts, signs, trees.
//!
//! On each side the road is cut into cells of one object each. Its place and its mean cross section depend on the seed
//! and the cell alone. They are the same in every scan. On a curve the sides bend with the road. If the lanes of a plan
//! reach farther, the objects stand beside them.

use super::body::Outlines;
use super::echo::{Antenna, Fluctuation};
use super::receiver::Echoes;
use super::scene::Scene;
use crate::random::{Random, fixed, hash};
use road::Axis;
use scenario::plan::Lanes;

/// Number of the random numbers' stream; vehicles have those below.
const STREAM: u64 = 1 << 20;

/// Least distance of an object from the lanes, m. Chosen: that of a post from the edge of a narrow hard strip.
const CLEAR_M: f64 = 1.0;

#[derive(Clone, Copy, Debug)]
pub struct Roadside {
    /// Objects on each side of a kilometre; 0: none.
    pub objects_per_km: f64,
    /// Distance of the nearest from the centre of the ego's lane, m.
    pub offset_m: f64,
    /// Mean cross section, m². It is exponential over the objects.
    pub area_m2: f64,
    /// Fluctuation of each from scan to scan.
    pub fluctuation: Fluctuation,
    /// Probability that an object is missing from a scan, whatever its echo is like.
    pub dropout_probability: f64,
    /// Factor on the power of what a vehicle hides; 1: nothing hides anything.
    pub hidden_factor: f64,
    /// Depth of the strip in which objects stand, m.
    pub depth_m: f64,
}

impl Roadside {
    /// Adds the echoes of what stands within range.
    pub(super) fn reflect(
        &self,
        seed: u64,
        (scene, outlines): (&Scene, &Outlines),
        road: Option<(&Axis, &Lanes)>,
        antenna: &Antenna,
        echoes: &mut Echoes,
    ) {
        if self.objects_per_km <= 0.0 {
            return;
        }
        let cell_m = 1e3 / self.objects_per_km;
        let ego = &scene.ego;
        let plane = scene.plane.as_ref().zip(road);
        let mut random = Random::of_scan(seed, STREAM, scene.time_ns);
        // A road that bends is longer than the range.
        let window_m = if plane.is_some() { 1.1 } else { 1.0 } * antenna.max_range_m;
        let (first, last) = (ego.position_m / cell_m, (ego.position_m + window_m) / cell_m);
        let velocity_mps = match plane {
            Some((plane, _)) => (-plane.ego.velocity_mps.0, -plane.ego.velocity_mps.1),
            None => (-ego.speed_mps, 0.0),
        };
        for cell in first.floor() as i64..=last.floor() as i64 {
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                let object = hash(seed, STREAM.wrapping_add_signed(2 * cell + side));
                let along_m = (cell as f64 + fixed(object, 0)) * cell_m;
                let depth_m = self.depth_m * fixed(object, 1);
                let place = match plane {
                    Some((plane, (road, lanes))) => {
                        let [right_m, left_m] = lanes.edges_m(along_m);
                        let edge_m = if side == 0 { left_m } else { -right_m };
                        let from_m = self.offset_m.max(edge_m + CLEAR_M);
                        plane.point(road, along_m, sign * (from_m + depth_m))
                    }
                    None => (along_m - ego.position_m, sign * (self.offset_m + depth_m)),
                };
                let scanned = hash(object, scene.time_ns as u64);
                let is_missing =
                    self.dropout_probability > 0.0 && fixed(scanned, 3) < self.dropout_probability;
                // Drawn also for what is out of sight: the others' draws do not depend on it.
                let fluctuation = self.fluctuation.draw(&mut random);
                let mean_m2 = || -self.area_m2 * libm::log(1.0 - fixed(object, 2));
                let area_m2 = || mean_m2() * fluctuation();
                let Some(mut echo) = antenna.echo(place, velocity_mps, area_m2) else {
                    continue;
                };
                if is_missing {
                    continue;
                }
                if self.hidden_factor < 1.0 && outlines.hide(None, place) {
                    echo.power *= self.hidden_factor;
                }
                echoes.add(echo);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::numbers::Numbers;
    use super::super::scene::Ego;
    use super::*;

    const ROADSIDE: Roadside = Roadside {
        objects_per_km: 100.0,
        offset_m: 8.0,
        area_m2: 100.0,
        fluctuation: Fluctuation::None,
        dropout_probability: 0.0,
        hidden_factor: 1.0,
        depth_m: 3.0,
    };

    /// Places of the objects on the road, m, and how far beside it.
    fn seen(position_m: f64) -> Vec<(f64, f64)> {
        let ego = Ego { position_m, speed_mps: 30.0, acceleration_mps2: 0.0 };
        let scene = Scene::new(0, ego, &[]);
        let mut echoes = Echoes::new(100, &Numbers::DEFAULT);
        let outlines = Outlines::with_room(0);
        ROADSIDE.reflect(
            7,
            (&scene, &outlines),
            None,
            &Antenna::new(40.0, 0.0, 60.0, 150.0),
            &mut echoes,
        );
        let place = |echo: &super::super::echo::Echo| {
            let (sine, cosine) = libm::sincos(echo.azimuth_rad);
            assert!((echo.range_rate_mps + 30.0 * cosine).abs() < 1e-9, "it stands");
            (position_m + echo.range_m * cosine, echo.range_m * sine)
        };
        echoes.list().iter().map(place).collect()
    }

    #[test]
    fn a_standing_object_is_where_it_was() {
        let (before, after) = (seen(1000.0), seen(1010.0));
        assert!((20..=30).contains(&before.len()), "{}", before.len());
        let kept = before.iter().filter(|(x, y)| {
            after.iter().any(|(x2, y2)| (x - x2).abs() < 1e-6 && (y - y2).abs() < 1e-6)
        });
        assert!(kept.count() >= before.len() - 4);
        assert!(before.iter().all(|(_, y)| (8.0..=11.0).contains(&y.abs())));
    }
}
