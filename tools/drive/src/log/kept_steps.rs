//! The steps of a long drive that the launcher keeps.

use runtime::Mode;

/// Steps of a realtime run that are kept in full: ten minutes at the usual period of the plant.
pub const MOST_IN_REALTIME: usize = 60_000;
/// The same in lockstep: an hour.
const MOST_IN_LOCKSTEP: usize = 360_000;

/// Keeps every n-th step. n is 1 in a short drive and grows with a long one, so that memory does not grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeptSteps {
    every: u64,
    most: usize,
    /// Steps between two with a sample of every topic.
    whole_stride: u64,
}

impl KeptSteps {
    /// Makes it for a run with these steps between two releases of the radar and of the controller.
    pub fn new(mode: Mode, radar_stride: u64, controller_stride: u64) -> Self {
        let most = match mode {
            Mode::Realtime => MOST_IN_REALTIME,
            Mode::Lockstep => MOST_IN_LOCKSTEP,
        };
        Self {
            every: 1,
            most,
            whole_stride: least_common_multiple(radar_stride, controller_stride),
        }
    }

    /// True if `step` is kept.
    pub fn has(self, step: u64) -> bool {
        step.is_multiple_of(self.every)
    }

    /// True if `count` steps are too many; fewer are kept from then on.
    pub fn thin_out(&mut self, count: usize) -> bool {
        // After thinning out, each step has a sample of every topic and takes more memory.
        let most = if self.every == 1 { self.most } else { MOST_IN_REALTIME };
        let thins_out = count >= most;
        if thins_out {
            self.every = if self.every == 1 { self.whole_stride.max(2) } else { 2 * self.every };
        }
        thins_out
    }
}

fn least_common_multiple(a: u64, b: u64) -> u64 {
    let (mut divisor, mut rest) = (a, b);
    while rest > 0 {
        (divisor, rest) = (rest, divisor % rest);
    }
    a / divisor * b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_steps_have_a_sample_of_every_topic() {
        assert_eq!(least_common_multiple(5, 10), 10);
        assert_eq!(least_common_multiple(4, 6), 12);
        assert_eq!(least_common_multiple(1, 1), 1);
    }

    #[test]
    fn the_steps_of_a_long_drive_do_not_depend_on_when_it_is_thinned_out() {
        let left = |chunk: u64| {
            let mut kept = KeptSteps::new(Mode::Lockstep, 5, 10);
            let mut steps = Vec::new();
            for begin in (0..4_000_000_u64).step_by(usize::try_from(chunk).expect("small")) {
                steps.extend((begin..begin + chunk).filter(|&step| kept.has(step)));
                while kept.thin_out(steps.len()) {
                    steps.retain(|&step| kept.has(step));
                }
            }
            (steps.len(), kept)
        };
        let (count, kept) = left(1);
        assert!(count < MOST_IN_REALTIME && kept.every == 80, "{count} {kept:?}");
        assert_eq!(left(64), (count, kept));
        assert_eq!(left(20_000), (count, kept));
    }
}
