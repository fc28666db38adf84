//! The options for the outputs of a result, and their delivery.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use supervise::{Error, MachineError};

use super::console::width;
use super::document::Document;
use crate::output::{OutputDirectory, OutputOptions};
use crate::print;

/// Directory and forms of the results.
#[derive(Clone, Debug, Default, Args)]
pub struct ResultOptions {
    /// The directory.
    #[command(flatten)]
    pub output: OutputOptions,
    /// Print the results as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
    /// Write the verdicts as JUnit XML too, for a continuous integration job
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Write the verdict and the tables as Markdown too
    #[arg(long, value_name = "FILE")]
    pub markdown: Option<PathBuf>,
}

impl ResultOptions {
    /// Writes the result into its directory and prints it, as text or as JSON. Printing comes first: a full disk does
    /// not take what was measured.
    ///
    /// # Errors
    /// A file that cannot be written, after everything was printed.
    pub fn deliver(&self, document: &Document, output: &OutputDirectory) -> Result<(), Error> {
        let written = write(document, output);
        print::show(self.json, document)?;
        if !self.json {
            print::out(&output.places())?;
        }
        written?;
        self.export(document)
    }

    /// The same for runs that were interrupted: JSON is for whole results.
    pub fn deliver_interrupted(
        &self,
        document: &Document,
        output: &OutputDirectory,
    ) -> Result<(), Error> {
        let written = write(document, output);
        if !self.json {
            print::out(&(document.console(width()) + &output.places()))?;
        }
        written
    }

    /// Writes the forms for a continuous integration job alone, for commands with a page of their own.
    pub fn export(&self, document: &Document) -> Result<(), Error> {
        let write = |option, path: &Option<PathBuf>, text: &dyn Fn() -> String| {
            let Some(path) = path else { return Ok(()) };
            std::fs::write(path, text()).map_err(|reason| {
                let expected = "expected a path in a directory that can be written";
                Error::from(MachineError(format!(
                    "cannot write {option} {}: {reason}; {expected}",
                    path.display()
                )))
            })
        };
        let junit = write("--junit", &self.junit, &|| document.junit());
        write("--markdown", &self.markdown, &|| document.markdown()).and(junit)
    }
}

fn write(document: &Document, output: &OutputDirectory) -> Result<(), Error> {
    document.files.iter().try_for_each(|(name, contents)| output.write(name, contents))?;
    output.write(&document.json_name(), document.json.as_bytes())?;
    output.write(crate::FILE, document.page().as_bytes())
}

impl Document {
    /// Exit status: 0 when all is well, else 1.
    pub fn exit_code(&self) -> ExitCode {
        if self.succeeds.unwrap_or(self.ok) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}
