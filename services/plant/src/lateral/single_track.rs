//! The linear single track: both wheels of an axle in one, tyre forces in proportion to slip angles.
//!
//! ```text
//! v_y' = c_f α_f + c_r α_r − v r          α_f = δ − (v_y + a r) / v
//! r'   = (a c_f α_f − b c_r α_r) / k²     α_r =   − (v_y − b r) / v
//! ```
//!
//! a and b are the distances of the centre of gravity from front and rear axle. k² = I_z / m, and c_f and c_r are
//! cornering stiffnesses by mass. These follow from the compliances. In steady driving at 1 m/s² lateral acceleration
//! the rear slip angle is `slip_rad_per_mps2`, and the front one larger by `understeer_rad_per_mps2`. So the steering
//! angle of a circle is δ = κ (L + EG v²) with EG the understeer gradient.
//!
//! A step is the trapezoidal rule: two linear equations, solved in closed form. Below [`DYNAMIC_MPS`] the
//! wheels roll without delay. The track is in its steady state at once, as the equations above would become stiff.

use scenario::lateral::Lateral as Keys;
use serde::{Deserialize, Serialize};

/// Speed from which the track has dynamics of its own, m/s. Chosen: its time constants are below 0.05 s there.
const DYNAMIC_MPS: f64 = 5.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleTrack {
    /// Distance of the centre of gravity from the front and the rear axle, m.
    pub front_m: f64,
    rear_m: f64,
    /// Cornering stiffness by mass, m/s² per rad.
    front_stiffness: f64,
    rear_stiffness: f64,
    /// Moment of inertia by mass, m².
    gyration_m2: f64,
    slip_rad_per_mps2: f64,
    understeer_rad_per_mps2: f64,
}

/// Motion of the centre of gravity across the body's axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Slip {
    pub lateral_mps: f64,
    pub yaw_radps: f64,
}

impl SingleTrack {
    pub fn new(keys: &Keys, mass_kg: f64) -> Self {
        let wheelbase_m = keys.wheelbase_m.value();
        let front_m = keys.cg_share.value() * wheelbase_m;
        let rear_m = wheelbase_m - front_m;
        let (slip, understeer) =
            (keys.slip_rad_per_mps2.value(), keys.understeer_rad_per_mps2.value());
        // Oversteer is at most a part of the rear axle's compliance.
        let front_slip = (slip + understeer).max(0.1 * slip);
        Self {
            front_m,
            rear_m,
            front_stiffness: rear_m / (wheelbase_m * front_slip),
            rear_stiffness: front_m / (wheelbase_m * slip),
            gyration_m2: keys.yaw_inertia_kgm2.value() / mass_kg,
            slip_rad_per_mps2: slip,
            understeer_rad_per_mps2: front_slip - slip,
        }
    }

    /// Steering angle of a circle of this curvature, rad.
    pub fn steering_rad(&self, curvature_perm: f64, speed_mps: f64) -> f64 {
        curvature_perm * self.steering_way_m(speed_mps)
    }

    pub fn steady(&self, steering_rad: f64, speed_mps: f64) -> Slip {
        let yaw_radps = steering_rad * speed_mps / self.steering_way_m(speed_mps);
        let rear_rad = self.slip_rad_per_mps2 * speed_mps * yaw_radps;
        Slip { lateral_mps: self.rear_m * yaw_radps - rear_rad * speed_mps, yaw_radps }
    }

    /// Steering angle by curvature, m.
    fn steering_way_m(&self, speed_mps: f64) -> f64 {
        self.front_m + self.rear_m + self.understeer_rad_per_mps2 * speed_mps * speed_mps
    }

    /// True if the tyres build their forces up with a delay at this speed.
    pub fn is_dynamic(&self, speed_mps: f64) -> bool {
        speed_mps >= DYNAMIC_MPS
    }

    /// Moves on by `h` seconds at a steering angle. Its mean is `steering_rad`, and its last value `end_rad`.
    pub fn step(
        &self,
        slip: Slip,
        steering_rad: f64,
        end_rad: f64,
        speed_mps: f64,
        h: f64,
    ) -> Slip {
        if !self.is_dynamic(speed_mps) {
            return self.steady(end_rad, speed_mps);
        }
        let Self { front_m: a, rear_m: b, front_stiffness: cf, rear_stiffness: cr, .. } = *self;
        let (k2, v) = (self.gyration_m2, speed_mps);
        // The system's matrix and its input.
        let turning = (b * cr - a * cf) / v;
        let (m11, m12) = (-(cf + cr) / v, turning - v);
        let (m21, m22) = (turning / k2, -(a * a * cf + b * b * cr) / (k2 * v));
        let (in1, in2) = (cf * steering_rad, a * cf * steering_rad / k2);
        // (I − h/2 M) x₁ = (I + h/2 M) x₀ + h u
        let half = 0.5 * h;
        let Slip { lateral_mps: y, yaw_radps: r } = slip;
        let right1 = y + half * (m11 * y + m12 * r) + h * in1;
        let right2 = r + half * (m21 * y + m22 * r) + h * in2;
        let (l11, l12) = (1.0 - half * m11, -half * m12);
        let (l21, l22) = (-half * m21, 1.0 - half * m22);
        let determinant = l11 * l22 - l12 * l21;
        Slip {
            lateral_mps: (l22 * right1 - l12 * right2) / determinant,
            yaw_radps: (l11 * right2 - l21 * right1) / determinant,
        }
    }
}
