//! Progress bars.

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};

/// A bar over `runs` on a terminal; hidden elsewhere.
pub fn count_bar(runs: usize, quiet: bool) -> ProgressBar {
    use std::io::IsTerminal;
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {left} to go")
        .expect("the template is valid")
        .with_key("left", |state: &ProgressState, text: &mut dyn std::fmt::Write| {
            // The remaining time is unknown until the first run has ended.
            let written = match state.pos() {
                0 => text.write_str("–"),
                _ => write!(text, "{:#}", HumanDuration(state.eta())),
            };
            written.expect("a line takes all");
        });
    ProgressBar::new(runs as u64).with_style(style)
}
