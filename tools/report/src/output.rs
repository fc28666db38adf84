//! Where a run's results go.

use group::Error;
use runtime::histogram_log;
use runtime::statistics::Latencies;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A directory for results, made before the run so that nothing can be lost after it.
#[derive(Debug)]
pub struct OutputDirectory {
    path: PathBuf,
}

impl OutputDirectory {
    /// Makes `chosen`, or a new directory below `runs` named after the time and `scenario`.
    pub fn create(chosen: Option<&Path>, scenario: &str) -> Result<Self, Error> {
        let error = |path: &Path| {
            let path = path.to_owned();
            move |reason| Error::Path { action: "write results to", path, reason }
        };
        if let Some(path) = chosen {
            std::fs::create_dir_all(path).map_err(error(path))?;
            let output = Self { path: path.to_owned() };
            // Refused now rather than after the run.
            output.write(".writable", b"")?;
            std::fs::remove_file(path.join(".writable")).map_err(error(path))?;
            return Ok(output);
        }
        let runs = Path::new("runs");
        std::fs::create_dir_all(runs).map_err(error(runs))?;
        let time = jiff::Zoned::now().strftime("%Y%m%d-%H%M%S").to_string();
        for attempt in 1.. {
            let suffix = if attempt == 1 { String::new() } else { format!("-{attempt}") };
            let path = runs.join(format!("{time}-{scenario}{suffix}"));
            match std::fs::create_dir(&path) {
                Ok(()) => return Ok(Self { path }),
                Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(error(&path)(e)),
            }
        }
        unreachable!("some attempt finds a free name or fails")
    }

    /// The directory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes tagged histograms as `histograms.hlog`, which the tools of the HdrHistogram family read.
    pub fn write_histograms(&self, histograms: &[(String, Latencies)]) -> Result<(), Error> {
        let mut log = Vec::new();
        let tagged = histograms.iter().map(|(tag, histogram)| (tag.as_str(), histogram));
        histogram_log::write(&mut log, tagged).expect("memory takes all, and our tags are words");
        self.write("histograms.hlog", &log)
    }

    /// Writes a file, whole or not at all.
    pub fn write(&self, name: &str, contents: &[u8]) -> Result<(), Error> {
        let path = self.path.join(name);
        let temporary = self.path.join(format!(".{name}.part"));
        let written = std::fs::File::create(&temporary)
            .and_then(|mut file| file.write_all(contents).and_then(|()| file.sync_all()))
            .and_then(|()| std::fs::rename(&temporary, &path));
        written.map_err(|reason| {
            let _ = std::fs::remove_file(&temporary);
            Error::Path { action: "write", path, reason }
        })
    }
}
