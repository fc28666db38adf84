//! The bar over the estimated time of a benchmark.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// A bar over the estimated time on a terminal; hidden elsewhere.
pub fn progress_bar(whole: Duration, quiet: bool) -> ProgressBar {
    use std::io::IsTerminal;
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    eprintln!("about {} s", whole.as_secs());
    let style = ProgressStyle::with_template("{msg:44} {wide_bar} {eta} to go")
        .expect("the template is valid");
    ProgressBar::new(millis(whole)).with_style(style)
}

/// Length in whole milliseconds, as the bar counts.
pub fn millis(duration: Duration) -> u64 {
    u64::try_from(duration.as_millis()).unwrap_or(u64::MAX)
}
