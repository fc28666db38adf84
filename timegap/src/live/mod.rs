//! The view of a running simulation in the terminal (`--watch`).
//!
//! ```text
//! supervisor ─ Moment ─► LiveFeed ─ bounded channel ─► terminal thread
//! ```
//!
//! The supervisor never waits for the view. At most ten times a second it copies the news, and a view that does not
//! keep up misses them.

mod feed;
mod terminal;

use clap::Args;
use feed::LiveFeed;
use scenario::Scenario;
use std::sync::mpsc::sync_channel;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use supervise::Error;

/// Most frames that wait for the view.
const BACKLOG: usize = 64;
const TERMINAL_PATIENCE: Duration = Duration::from_secs(1);

#[derive(Clone, Debug, Default, Args)]
pub struct LiveOptions {
    /// Show the running simulation in this terminal; q, or closing the terminal, ends the run
    #[arg(long)]
    pub watch: bool,
}

/// The view of a run, if one is open.
pub struct Live(Option<(LiveFeed, JoinHandle<()>)>);

impl Live {
    /// Opens the view if it is requested; `driver` is the law or program that drives.
    pub fn open(options: &LiveOptions, scenario: &Scenario, driver: &str) -> Result<Self, Error> {
        if !options.watch {
            return Ok(Self(None));
        }
        let (sender, updates) = sync_channel(BACKLOG);
        let title = format!("{} · {driver}", scenario.name.as_str());
        let terminal = terminal::watch(title, updates)?;
        let modes = controller::laws::mode_names(scenario);
        let feed = LiveFeed::new(scenario.duration_s.value(), modes, sender);
        Ok(Self(Some((feed, terminal))))
    }

    pub fn look(&mut self, moment: &supervise::Moment<'_>) {
        if let Some((feed, _)) = &mut self.0 {
            feed.look(moment);
        }
    }

    pub fn end(self) {
        let Some((feed, terminal)) = self.0 else { return };
        drop(feed);
        let begun = Instant::now();
        // A terminal that takes no more output must not delay the results.
        while !terminal.is_finished() && begun.elapsed() < TERMINAL_PATIENCE {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}
