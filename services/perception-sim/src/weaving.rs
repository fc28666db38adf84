//! Lateral position of a vehicle that does one lateral motion after the other.
//!
//! A vehicle that wanders on a long drive has many motions. Few of them are in progress at a time. The others are
//! summed up once: where the vehicle is after the first one, two, three and so on.

use scenario::actor::{Actor, LateralMotion};

#[derive(Clone, Debug)]
pub(crate) struct Weaving {
    motions: Vec<LateralMotion>,
    /// Time at which the first n motions are over, s.
    over_s: Vec<f64>,
    /// Lateral position after the first n motions, m; the first one is that of the start.
    after_m: Vec<f64>,
}

impl Weaving {
    pub(crate) fn new(actor: &Actor) -> Self {
        let motions = actor.lateral.clone();
        let mut over_s = f64::NEG_INFINITY;
        let ends = motions.iter().map(|motion| {
            over_s = over_s.max(motion.time_s.value() + motion.duration_s.value());
            over_s
        });
        let over_s = ends.collect();
        let mut lateral_m = actor.lateral_offset_m.value();
        let mut after_m = vec![lateral_m];
        after_m.extend(motions.iter().map(|motion| {
            (lateral_m, _) = moved((lateral_m, 0.0), motion, f64::INFINITY);
            lateral_m
        }));
        Self { motions, over_s, after_m }
    }

    pub(crate) fn at(&self, time_s: f64) -> (f64, f64) {
        // Rounding must not end a motion that its own clock has not ended.
        let over = self.over_s.partition_point(|over_s| *over_s < time_s - 1e-6);
        let rest = self.motions[over..].iter();
        rest.take_while(|motion| motion.time_s.value() <= time_s)
            .fold((self.after_m[over], 0.0), |state, motion| moved(state, motion, time_s))
    }
}

/// Position and speed after the part of a motion that is done at a time.
fn moved((lateral_m, speed_mps): (f64, f64), motion: &LateralMotion, time_s: f64) -> (f64, f64) {
    let (share, share_per_s) = motion.progress(time_s);
    let way_m = motion.to_m.value() - lateral_m;
    (lateral_m + share * way_m, share_per_s * way_m + (1.0 - share) * speed_mps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use scenario::Scenario;

    fn actor(motions: &[(f64, f64, f64, bool)]) -> Actor {
        let motions: Vec<String> = motions
            .iter()
            .map(|(time_s, to_m, duration_s, rises)| {
                let rise = if *rises { ", rise_s = 0.2" } else { "" };
                format!("{{ time_s = {time_s}, to_m = {to_m}, duration_s = {duration_s}{rise} }}")
            })
            .collect();
        let text = format!(
            "schema_version = 1\nname = \"x\"\n[[actors]]\nname = \"a\"\ngap_m = 50\n\
             initial_speed_mps = 20\nlateral_offset_m = 3.5\nlateral = [{}]\n",
            motions.join(", ")
        );
        let scenario = Scenario::parse("x.toml", &text).unwrap_or_else(|error| panic!("{error}"));
        scenario.actors[0].clone()
    }

    proptest! {
        /// The sums change no bit of what all motions give one after the other.
        #[test]
        fn it_is_where_all_motions_bring_it(
            parts in prop::collection::vec((0.1_f64..3.0, -4.0_f64..4.0, 0.5_f64..4.0, any::<bool>()), 0..12),
        ) {
            let mut over_s = 0.0;
            let motions: Vec<_> = parts
                .into_iter()
                .map(|(pause_s, to_m, duration_s, rises)| {
                    let begin_s = over_s + pause_s;
                    over_s = begin_s + duration_s;
                    (begin_s, to_m, duration_s, rises)
                })
                .collect();
            let actor = actor(&motions);
            let weaving = Weaving::new(&actor);
            for step in 0..4_000 {
                let time_s = f64::from(step) * 0.01;
                let start = (actor.lateral_offset_m.value(), 0.0);
                let all =
                    actor.lateral.iter().fold(start, |state, motion| moved(state, motion, time_s));
                let found = weaving.at(time_s);
                prop_assert_eq!(found.0.to_bits(), all.0.to_bits(), "{} {}", time_s, all.0);
                prop_assert_eq!(found.1.to_bits(), all.1.to_bits(), "{} {}", time_s, all.1);
            }
        }
    }
}
