//! Whether the radar still shows what it should show.
//!
//! An echo well above the threshold comes again in the next scan, moved on by its own range rate. In a scan without
//! such echoes the radar is blind. The share of those that came again, with a memory of [`MEMORY_S`], is what the radar
//! sees:
//!
//! ```text
//! scan k:      x         x     x        x      strong echoes
//! scan k+1:    x               x        x      where range + rate · period is: 3 of 4 came again
//! ```
//!
//! A radar without any strong echo has nothing to compare. If the map shows posts beside the road, it is blind after
//! [`DARK_S`].

use messages::Detection;

/// Memory of the share, s. Chosen: 20 scans of 50 ms.
const MEMORY_S: f64 = 1.0;
/// An echo is strong from this signal-to-noise ratio on, dB. Chosen: 10 dB above the usual threshold of 12 dB. Nine of
/// ten such echoes of Swerling's case 1 come again.
const STRONG_DB: f64 = 22.0;
/// Nearer echoes are left out, m: their direction changes much from scan to scan, and posts leave the field of view.
const NEAREST_M: f64 = 25.0;
/// Farther echoes are left out, m: they are weak.
const FARTHEST_M: f64 = 80.0;
/// An echo that came again is this near in range, m, range rate, m/s, and azimuth, rad.
const GATE: (f64, f64, f64) = (1.5, 1.5, 0.06);
/// Share below which the emergency brake is blind. Chosen: with one echo in three scans an object needs half a second
/// to be confirmed. A warning precedes the braking by at least as much (UN R152, 5.2.1.1).
const BLIND_BELOW: f64 = 0.33;
const SEES_FROM: f64 = 0.5;
/// Time without any strong echo after which a radar among posts is blind, s.
const DARK_S: f64 = 1.0;
const MAX_ECHOES: usize = 128;
/// Weight of what is assumed at the start: a radar that sees.
const ASSUMED: f64 = 8.0;

#[derive(Clone, Debug)]
pub struct Sight {
    echoes: Vec<Detection>,
    last_ns: Option<i64>,
    came: f64,
    expected: f64,
    dark_s: f64,
    has_posts: bool,
    /// Too little is seen to brake in time for what comes.
    pub is_blind: bool,
}

impl Sight {
    /// A radar on a road that `has_posts` beside it.
    pub fn new(has_posts: bool) -> Self {
        Self {
            echoes: Vec::with_capacity(MAX_ECHOES),
            last_ns: None,
            came: ASSUMED,
            expected: ASSUMED,
            dark_s: 0.0,
            has_posts,
            is_blind: false,
        }
    }

    /// Takes the detections that were acquired at `scan_ns`. A scan that is not later than the last one is passed
    /// over. Allocates nothing.
    pub fn take_scan(&mut self, scan_ns: i64, detections: &[Detection]) {
        let period_s = self.last_ns.map_or(0.0, |last_ns| (scan_ns - last_ns) as f64 / 1e9);
        if self.last_ns.is_some() && period_s <= 0.0 {
            return;
        }
        self.last_ns = Some(scan_ns);
        let kept = libm::exp(-period_s / MEMORY_S);
        (self.came, self.expected) = (self.came * kept, self.expected * kept);
        for echo in &self.echoes {
            let range_m = echo.range_m + echo.range_rate_mps * period_s;
            let is_again = |detection: &Detection| {
                (detection.range_m - range_m).abs() < GATE.0
                    && (detection.range_rate_mps - echo.range_rate_mps).abs() < GATE.1
                    && (detection.azimuth_rad - echo.azimuth_rad).abs() < GATE.2
            };
            if range_m > NEAREST_M {
                self.expected += 1.0;
                self.came += f64::from(u8::from(detections.iter().any(is_again)));
            }
        }
        let strong =
            (detections.iter()).filter(|echo| echo.snr_db > STRONG_DB && echo.ambiguity_group == 0);
        let is_dark = strong.clone().next().is_none();
        self.dark_s = if is_dark { self.dark_s + period_s } else { 0.0 };
        let compared = strong.filter(|echo| (NEAREST_M..FARTHEST_M).contains(&echo.range_m));
        self.echoes.clear();
        self.echoes.extend(compared.take(MAX_ECHOES));
        self.is_blind = self.share() < if self.is_blind { SEES_FROM } else { BLIND_BELOW };
    }

    /// Share of the strong echoes that came again; 0 after [`DARK_S`] without any.
    pub fn share(&self) -> f64 {
        match self.has_posts && self.dark_s >= DARK_S {
            true => 0.0,
            false => self.came / self.expected.max(1e-9),
        }
    }

    /// Share of the scans in which an object is to be expected: less than 1 while blind.
    pub fn expected_share(&self) -> f64 {
        if self.is_blind { self.share() } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn echo(range_m: f64, azimuth_rad: f64) -> Detection {
        Detection {
            range_m,
            range_rate_mps: -20.0,
            azimuth_rad,
            snr_db: 30.0,
            ..Detection::zeroed()
        }
    }

    /// Posts every 10 m that come nearer with 20 m/s, in the scans that `sees` names; returns the last state.
    fn drive(sight: &mut Sight, scans: std::ops::Range<i64>, sees: impl Fn(i64) -> bool) -> bool {
        for scan in scans {
            let moved_m = (scan % 10) as f64;
            let posts: Vec<Detection> = (2..8)
                .map(|k| 10.0 * f64::from(k) - moved_m)
                .map(|x_m| echo(libm::hypot(x_m, 8.0), libm::atan2(8.0, x_m)))
                .collect();
            let shown = if sees(scan) { &posts[..] } else { &[] };
            sight.take_scan(scan * 50_000_000, shown);
        }
        sight.is_blind
    }

    #[test]
    fn a_radar_that_shows_its_echoes_again_sees() {
        let mut sight = Sight::new(true);
        assert!(!drive(&mut sight, 0..100, |_| true));
        assert!(sight.share() > 0.95, "{}", sight.share());
    }

    #[test]
    fn one_scan_of_six_is_blind_and_all_of_them_are_not_again() {
        let mut sight = Sight::new(true);
        assert!(drive(&mut sight, 0..100, |scan| scan % 6 == 0));
        assert!(!drive(&mut sight, 100..200, |_| true));
    }

    #[test]
    fn half_of_the_scans_in_pairs_keep_a_state_between_its_two_limits() {
        let mut sight = Sight::new(true);
        // In two scans in a row the second one shows what the first one did; then two show nothing.
        assert!(!drive(&mut sight, 0..200, |scan| scan % 4 < 2), "{}", sight.share());
        assert!((BLIND_BELOW..SEES_FROM + 0.1).contains(&sight.share()), "{}", sight.share());
    }

    #[test]
    fn darkness_is_blind_where_there_are_posts_only() {
        let mut among_posts = Sight::new(true);
        assert!(!drive(&mut among_posts, 0..20, |_| false), "not yet");
        assert!(drive(&mut among_posts, 20..22, |_| false));
        assert!(!drive(&mut Sight::new(false), 0..100, |_| false));
    }

    #[test]
    fn an_old_scan_is_passed_over() {
        let mut sight = Sight::new(true);
        drive(&mut sight, 0..10, |_| true);
        let share = sight.share();
        sight.take_scan(0, &[]);
        assert_eq!(sight.share(), share);
    }
}
