//! Views of a running simulation: in the terminal (`--watch`), in browsers (`--serve`).
//!
//! ```text
//! supervisor ─ Moment ─► LiveFeed ─ bounded channels ─► terminal thread
//!                                                   └─► server thread ─► browsers
//! ```
//!
//! The supervisor never waits for a view. At most ten times a second it copies the news, and a view that does not keep
//! up misses them.

mod feed;
mod ground;
mod history;
mod http;
mod server;
mod terminal;

use clap::Args;
use feed::LiveFeed;
use group::Error;
use scenario::Scenario;
use server::Server;
use std::sync::mpsc::sync_channel;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Most frames that wait for a view.
const BACKLOG: usize = 64;
/// Time to restore the terminal.
const TERMINAL_PATIENCE: Duration = Duration::from_secs(1);
/// Port of `--serve` without a number.
const PORT: &str = "8170";

/// Views of a running simulation.
#[derive(Clone, Debug, Default, Args)]
pub struct LiveOptions {
    /// Show the running simulation in this terminal; q, or closing the terminal, ends the run
    #[arg(long)]
    pub watch: bool,
    /// Serve the running simulation to browsers of this machine on this port (0: any free one); open
    /// the printed address, which holds an access token
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = PORT)]
    pub serve: Option<u16>,
}

/// The open views of a run.
pub struct Live {
    feed: LiveFeed,
    terminal: Option<JoinHandle<()>>,
    server: Option<Server>,
}

impl Live {
    /// Opens the requested views; `driver` is the law or program that drives.
    pub fn open(options: &LiveOptions, scenario: &Scenario, driver: &str) -> Result<Self, Error> {
        let title = format!("{} · {driver}", scenario.name.as_str());
        let mut views = Vec::new();
        // The server first: it prints its address before the terminal view begins.
        let server = match options.serve {
            None => None,
            Some(port) => {
                let (sender, updates) = sync_channel(BACKLOG);
                views.push(sender);
                let server = Server::start(&title, &ground::json(scenario), port, updates)?;
                report::print::note(&format!("live at {}", server.url()));
                Some(server)
            }
        };
        let terminal = if options.watch {
            let (sender, updates) = sync_channel(BACKLOG);
            views.push(sender);
            Some(terminal::watch(title, updates)?)
        } else {
            None
        };
        let modes = controller::laws::mode_names(scenario);
        let feed = LiveFeed::new(scenario.duration_s.value(), modes, views);
        Ok(Self { feed, terminal, server })
    }

    /// Shows the present state of the run.
    pub fn look(&mut self, moment: &group::Moment<'_>) {
        self.feed.look(moment);
    }

    /// Shows the outcome of the run and waits until the views have drawn it.
    pub fn end(self, how: &str) {
        self.feed.end(how);
        if let Some(terminal) = self.terminal {
            let begun = Instant::now();
            // A terminal that takes no more output must not delay the results.
            while !terminal.is_finished() && begun.elapsed() < TERMINAL_PATIENCE {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        if let Some(server) = self.server {
            server.finish();
        }
    }
}
