//! Progress bars.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over so many runs on a terminal; nothing elsewhere.
pub fn count_bar(runs: usize, quiet: bool) -> ProgressBar {
    use std::io::IsTerminal;
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {eta} to go")
        .expect("the template is valid");
    ProgressBar::new(runs as u64).with_style(style)
}
