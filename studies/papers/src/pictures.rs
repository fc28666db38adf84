//! Pictures of a paper, for its page.

use report::RunPicture;
use report::chart::Plot;

/// Pictures of a paper, for its page.
#[derive(Default)]
pub struct Pictures {
    /// Drives, by their names.
    pub drives: Vec<(String, RunPicture)>,
    /// The paper's own figures.
    pub galleries: Vec<Gallery>,
}

impl Pictures {
    /// Adds those of another piece.
    pub fn extend(&mut self, other: Self) {
        self.drives.extend(other.drives);
        self.galleries.extend(other.galleries);
    }
}

impl std::fmt::Debug for Pictures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} drives, {} galleries", self.drives.len(), self.galleries.len())
    }
}

/// Plots below one heading.
pub struct Gallery {
    /// The heading.
    pub heading: String,
    /// The plots.
    pub plots: Vec<Plot>,
}
