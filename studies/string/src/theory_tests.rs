//! The measured gain against the transfer function of the closed loop.
//!
//! Between its bounds `acc-mpc` is a linear feedback of the measured state. Differences around the equilibrium give
//! its gains,
//!
//! ```text
//! u = k_g gap + k_r (v_l - v) + k_l a_l + k_v v + k_a a
//! ```
//!
//! held over a control period `T` before a lag `tau`. With `z = exp(j w T)`, the state `x = (gap, v, a)`
//! at the instants of control, and a lead at `v_l = exp(j w t)`:
//!
//! ```text
//! (z I - F - B K) x = e (z - 1)/(j w) + B (k_r + j w k_l),       G(j w) = v
//! F, B: the exact step of gap' = -v, v' = a, a' = (u - a)/tau;   e = (1, 0, 0)
//! ```

use std::f64::consts::TAU;

use controller::law::{Ego, Input, Law, Output, Target};
use controller::laws;
use scenario::Scenario;
use supervise::ScenarioOptions;

use super::scene::Plan;
use super::wave::Wave;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Complex(f64, f64);

impl Complex {
    fn times(self, other: Self) -> Self {
        Self(self.0 * other.0 - self.1 * other.1, self.0 * other.1 + self.1 * other.0)
    }

    fn minus(self, other: Self) -> Self {
        Self(self.0 - other.0, self.1 - other.1)
    }

    fn over(self, other: Self) -> Self {
        let square = other.0 * other.0 + other.1 * other.1;
        let Self(re, im) = self.times(Self(other.0, -other.1));
        Self(re / square, im / square)
    }

    fn magnitude(self) -> f64 {
        libm::hypot(self.0, self.1)
    }
}

/// Input of the law: gap, relative speed, acceleration of the lead, speed and acceleration.
type Gains = [f64; 5];

fn request(law: &mut dyn Law, scenario: &Scenario, told: Gains) -> f64 {
    let [gap_m, relative_speed_mps, lead_mps2, speed_mps, acceleration_mps2] = told;
    let target =
        Target { track_id: 1, gap_m, relative_speed_mps, acceleration_mps2: lead_mps2, age_s: 0.0 };
    let input = Input {
        time_s: 1.0,
        period_s: f64::from(scenario.controller.period_ms.value()) / 1e3,
        ego: Ego { position_m: 0.0, speed_mps, acceleration_mps2 },
        target: Some(target),
        set_speed_mps: scenario.set_speed_mps.value(),
        speed_limit_mps: f64::INFINITY,
        ..Input::default()
    };
    let mut output = Output::default();
    law.reset();
    law.step(&input, &mut output);
    output.request_mps2()
}

/// The law's gains at a speed, around the gap at which it asks for nothing.
fn gains(scenario: &Scenario, speed_mps: f64) -> Gains {
    let mut law = laws::build(scenario).expect("the scenario was checked");
    let mut request = |told: Gains| request(law.as_mut(), scenario, told);
    let (mut near, mut far) = (10.0, 120.0);
    for _ in 0..50 {
        let middle = 0.5 * (near + far);
        let asks = request([middle, 0.0, 0.0, speed_mps, 0.0]);
        if asks < 0.0 { near = middle } else { far = middle }
    }
    let equilibrium = [near, 0.0, 0.0, speed_mps, 0.0];
    std::array::from_fn(|index| {
        const DIFFERENCE: f64 = 0.02;
        let mut asked = [1.0, -1.0].map(|sign| {
            let mut told = equilibrium;
            told[index] += sign * DIFFERENCE;
            request(told)
        });
        asked[0] -= asked[1];
        asked[0] / (2.0 * DIFFERENCE)
    })
}

fn transfer(gains: Gains, tau_s: f64, period_s: f64, hz: f64) -> f64 {
    let [k_gap, k_rate, k_lead, k_speed, k_acceleration] = gains;
    let decay = libm::exp(-period_s / tau_s);
    let (c_speed, c_position) = (tau_s * (1.0 - decay), tau_s * (period_s - tau_s * (1.0 - decay)));
    let f = [[1.0, -period_s, -c_position], [0.0, 1.0, c_speed], [0.0, 0.0, decay]];
    let b = [-(0.5 * period_s * period_s - c_position), period_s - c_speed, 1.0 - decay];
    let k = [k_gap, k_speed - k_rate, k_acceleration];
    let omega = TAU * hz;
    let z = Complex(libm::cos(omega * period_s), libm::sin(omega * period_s));
    let lead = Complex(k_rate, omega * k_lead);
    let mut rows: Vec<[Complex; 4]> = (0..3)
        .map(|i| {
            let own = |j: usize| {
                let unit = if i == j { z } else { Complex(0.0, 0.0) };
                unit.minus(Complex(f[i][j] + b[i] * k[j], 0.0))
            };
            let pushed = Complex(b[i], 0.0).times(lead);
            let moved = z.minus(Complex(1.0, 0.0)).over(Complex(0.0, omega));
            let right =
                if i == 0 { Complex(pushed.0 + moved.0, pushed.1 + moved.1) } else { pushed };
            [own(0), own(1), own(2), right]
        })
        .collect();
    // Gauss-Jordan.
    for pivot in 0..3 {
        for row in 0..3 {
            if row != pivot {
                let factor = rows[row][pivot].over(rows[pivot][pivot]);
                let by = rows[pivot];
                for (value, other) in rows[row].iter_mut().zip(by) {
                    *value = value.minus(factor.times(other));
                }
            }
        }
    }
    rows[1][3].over(rows[1][1]).magnitude()
}

#[test]
fn the_measured_gain_is_that_of_the_closed_loop() {
    let options = ScenarioOptions {
        controller: Some("acc-mpc".into()),
        set: vec![scenario::Setting::new("perception.ideal", true)],
        ..ScenarioOptions::default()
    };
    let scenario = supervise::open("following", &options).expect("a built-in scenario");
    let tau_s = scenario.plant.actuator_time_constant_s.value();
    let period_s = f64::from(scenario.controller.period_ms.value()) / 1e3;
    let gains = gains(&scenario, 22.0);
    assert!(gains[0] > 0.0 && gains[1] > 0.0, "it closes up and follows: {gains:?}");
    let plan = Plan { laws: vec![scenario], vehicles: 1, wave: None };
    for period in [60.0, 30.0, 20.0, 12.0, 8.0, 4.0] {
        let hz = 1.0 / period;
        let behind = plan.behind_wave(hz).expect("a wave");
        let driven = supervise::in_process::run(&behind.laws[0]).expect("it drives");
        let wave = Wave::of(&plan.laws[0], plan.vehicles, hz).expect("a wave");
        let found = wave.amplitudes(&driven.drive).expect("to the end");
        let (measured, theory) =
            (found.car_mps / found.ahead_mps, transfer(gains, tau_s, period_s, hz));
        assert!(
            (measured / theory - 1.0).abs() < 0.02,
            "period {period} s: measured {measured:.4}, transfer function {theory:.4}"
        );
    }
}
