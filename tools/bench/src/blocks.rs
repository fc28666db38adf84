//! The judged part of a benchmark: comparisons in alternating blocks.

use super::Bench;
use super::chain::{self, Chain};
use super::goals::{self, Goal};
use super::paired::{Compared, Comparison, sessions};
use super::plan::{self, CHAIN_WAKES, Cell, ChainBlocks, Measure, millis};
use super::results::PairedRow;
use super::setup::{Conditions, Mechanism};
use super::statistics::Events;
use indicatif::ProgressBar;
use rand_core::Rng;
use rand_pcg::Pcg64;
use supervise::Error;

impl Bench<'_> {
    /// Makes all comparisons and judges the goals.
    pub fn compare(
        &mut self,
        comparisons: &[(Comparison, Conditions, u32)],
        chains: &[ChainBlocks],
        bar: &ProgressBar,
    ) -> Result<(), Error> {
        let quick = self.report.quick;
        let sessions = sessions(quick);
        let mut all: Vec<Option<Compared>> = comparisons.iter().map(|_| None).collect();
        for session in 0..sessions {
            for (&(comparison, conditions, period_us), all) in comparisons.iter().zip(&mut all) {
                bar.set_message(format!("{}, {}", comparison.name(), conditions.in_words()));
                let compared = self.stage.compare(comparison, conditions, period_us, session)?;
                match (all.as_mut(), compared) {
                    (Some(all), Some(compared)) => all.add(compared),
                    (None, compared) => *all = compared,
                    (Some(_), None) => {}
                }
                bar.inc(millis(plan::session_estimate(period_us)));
            }
        }
        for compared in all.into_iter().flatten() {
            let Compared { comparison, conditions, period_us, .. } = compared;
            let tag = conditions.tag(period_us);
            let name = comparison.name().replace(' ', "-");
            for (arm, histogram) in ["ours", "floor"].into_iter().zip(compared.histograms()) {
                self.histograms.push((format!("{name}-{arm}:{tag}"), histogram));
            }
            self.report.paired.push(PairedRow::of(&compared));
            self.judge(goals::of_comparison(&compared, !quick));
        }
        for blocks in chains {
            bar.set_message(format!("chain in blocks, {}", blocks.conditions.in_words()));
            self.chain_in_blocks(blocks)?;
            bar.inc(millis(blocks.estimate()));
        }
        Ok(())
    }

    /// Adds goals with this machine's caveats.
    fn judge(&mut self, goals: impl IntoIterator<Item = Goal>) {
        let caveats = &self.report.caveats;
        let said = goals.into_iter().map(|goal| Goal { caveats: caveats.clone(), ..goal });
        self.report.goals.extend(said);
    }

    /// Runs the group block after block, each with a block of the futex before or after it in random order.
    /// The metronome and the law are measured during the group's block.
    fn chain_in_blocks(&mut self, blocks: &ChainBlocks) -> Result<(), Error> {
        let ChainBlocks { conditions, period_us, block_s, .. } = *blocks;
        let cell = Cell { measure: Measure::Chain, conditions, period_us };
        let mut random = Pcg64::new(period_us.into(), 23);
        random.next_u64();
        let (mut done, mut ours, mut floor) = (Vec::new(), Events::default(), Events::default());
        for _ in 0..blocks.blocks {
            let futex = || self.stage.wake(Mechanism::Futex, conditions, period_us, CHAIN_WAKES);
            let (chain, futex) = if random.next_u64() >> 63 == 0 {
                let futex = futex()?;
                (chain::run(self.stage, &cell, block_s)?, futex)
            } else {
                let chain = chain::run(self.stage, &cell, block_s)?;
                (chain, futex()?)
            };
            if !chain.as_asked {
                return Ok(());
            }
            let missed = chain.timing.deadline_misses.unwrap_or(0);
            ours.events += missed;
            ours.cycles += chain.timing.cycles.unwrap_or(0).max(missed);
            let beside = chain.floor_events().unwrap_or_default();
            floor.events += beside.events;
            floor.cycles += beside.cycles;
            let futex_us = futex.latencies.percentiles_us().map(|p| p.p50);
            done.extend(futex_us.and_then(|us| block(&chain, us)));
        }
        self.judge(goals::of_chain(period_us, conditions.placement, &done));
        self.judge(goals::of_misses(conditions.placement, ours, floor));
        Ok(())
    }
}

/// Median net reaction time of a block, and the sum of its floors' medians, µs: two absolute sleeps, the law, a wake-up by
/// futex. `None` if one is missing.
fn block(chain: &Chain, futex_us: f64) -> Option<(f64, f64)> {
    let sleep_us = chain.floor.latencies.percentiles_us()?.p50;
    let floor_us = 2.0 * sleep_us + chain.timing.solve_us?.p50 + futex_us;
    Some((chain.timing.net_reaction_us?.p50, floor_us))
}
