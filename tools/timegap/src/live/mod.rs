//! A run while it goes on: in the terminal (`--watch`), in browsers (`--serve`).
//!
//! ```text
//! supervisor ─ Moment ─► LiveFeed ─ bounded channels ─► terminal thread
//!                                                   └─► server thread ─► browsers
//! ```
//!
//! The supervisor never waits for a view: at most ten times a second it copies what is new, and a
//! view that does not keep up misses it.

mod feed;
mod history;
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

/// Frames that wait for a view.
const BACKLOG: usize = 64;
/// Time that the terminal gets to be given back.
const TERMINAL_PATIENCE: Duration = Duration::from_secs(1);
/// Port of `--serve` without a number.
const PORT: &str = "8170";

/// How a run is looked at while it goes on.
#[derive(Clone, Debug, Default, Args)]
pub struct LiveOptions {
    /// Show the running simulation in the terminal; q ends it, and so does closing the terminal
    #[arg(long)]
    pub watch: bool,
    /// Show the running simulation to browsers of this machine, on this port (0: any); the address
    /// that is printed holds a token without which nothing is served
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = PORT)]
    pub serve: Option<u16>,
}

/// The views of a run.
pub struct Live {
    feed: LiveFeed,
    terminal: Option<JoinHandle<()>>,
    server: Option<Server>,
}

impl Live {
    /// Opens the views that were asked for; `driver` is the law or program that drives.
    pub fn open(options: &LiveOptions, scenario: &Scenario, driver: &str) -> Result<Self, Error> {
        let title = format!("{} · {driver}", scenario.name.as_str());
        let mut views = Vec::new();
        // The server first: it may say where it is before the terminal is taken.
        let server = match options.serve {
            None => None,
            Some(port) => {
                let (sender, updates) = sync_channel(BACKLOG);
                views.push(sender);
                let server = Server::start(&title, port, updates)?;
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
        let feed = LiveFeed::new(controller::laws::mode_names(scenario), views);
        Ok(Self { feed, terminal, server })
    }

    /// Shows the run as it is.
    pub fn look(&mut self, moment: &group::Moment<'_>) {
        self.feed.look(moment);
    }

    /// Says how the run ended and waits until the views have shown it.
    pub fn end(self, how: &str) {
        self.feed.end(how);
        if let Some(terminal) = self.terminal {
            let begun = Instant::now();
            // A terminal that takes no output any more must not hold the results up.
            while !terminal.is_finished() && begun.elapsed() < TERMINAL_PATIENCE {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        if let Some(server) = self.server {
            server.finish();
        }
    }
}
