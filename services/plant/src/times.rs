//! The times of all chains that end at the plant, as its report has them.

use crate::chains::Chains;
use crate::report::{Hops, Outcome, PlantReport};
use crate::signal_chain::SignalChain;
use runtime::{Figures, RuntimeError};

/// Paths of the chains.
pub(crate) const CONTROL_PATH: &str = "control";
pub(crate) const BRAKE_PATH: &str = "brake";

/// A report with them alone.
pub(crate) fn report(
    outcome: Outcome,
    control: &Chains,
    brake: Option<&Chains>,
    signals: &SignalChain,
) -> PlantReport {
    PlantReport {
        reaction_time_us: control.times.reaction.percentiles_us(),
        data_age_us: control.times.age.percentiles_us(),
        designed_wait_us: control.times.designed_wait.percentiles_us(),
        net_reaction_us: control.times.net_reaction.percentiles_us(),
        hops_us: control.hops_us(),
        worst_chains: control.worst.report(),
        late_reactions: control.times.late.get(),
        brake_reaction_time_us: brake.and_then(|brake| brake.times.reaction.percentiles_us()),
        brake_hops_us: brake.map_or_else(Hops::default, Chains::hops_us),
        signal_reaction_us: signals.whole.percentiles_us(),
        signal_hops_us: signals.hops_us(),
        histograms: {
            let mut all = control.histograms();
            all.extend(signals.histograms());
            all
        },
        ..PlantReport::empty(outcome)
    }
}

/// The same of a plant that is gone, from what its processes recorded. The longest chains died with it.
pub(crate) fn last(outcome: Outcome, figures: &Figures) -> Result<PlantReport, RuntimeError> {
    // Late chains were counted.
    let chains = |path| Chains::open(i64::MAX, path, figures);
    let (control, brake) = (chains(CONTROL_PATH)?, chains(BRAKE_PATH)?);
    Ok(report(outcome, &control, Some(&brake), &SignalChain::open(figures)?))
}
