//! `timegap print completions|man|reference`: what accompanies the command.

use crate::reference;
use clap::{Command, Subcommand, ValueEnum};
use clap_complete::Shell;
use report::print;
use std::process::ExitCode;
use supervise::Error;

#[derive(Debug, Subcommand)]
pub enum Generated {
    /// Completions for a shell
    Completions {
        /// The shell
        #[arg(value_enum)]
        shell: Shell,
    },
    /// The man page, in troff
    Man,
    /// A reference page of `docs`, in Markdown
    Reference {
        /// Its subject
        #[arg(value_enum)]
        page: Page,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Page {
    /// All messages
    Messages,
    /// All keys of a scenario
    Scenario,
}

/// `program` is the whole command line.
pub fn run(what: &Generated, program: Command) -> Result<ExitCode, Error> {
    let text = match what {
        Generated::Man => man(program),
        Generated::Reference { page: Page::Messages } => reference::messages_page(),
        Generated::Reference { page: Page::Scenario } => reference::scenario_page(),
        Generated::Completions { shell } => completions(*shell, program),
    };
    print::out(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn completions(shell: Shell, mut program: Command) -> String {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut program, "timegap", &mut text);
    String::from_utf8(text).expect("our names are text")
}

fn man(program: Command) -> String {
    let mut text = Vec::new();
    clap_mangen::Man::new(program).render(&mut text).expect("memory takes all");
    String::from_utf8(text).expect("our names are text")
}
