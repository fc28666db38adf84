//! `timegap generate`: files that accompany the command: completions, the man page, and reference pages of
//! `docs`.

use crate::reference;
use clap::{Args, Command, ValueEnum};
use clap_complete::Shell;
use group::Error;
use report::print;
use std::process::ExitCode;

/// Arguments of `generate`.
#[derive(Debug, Args)]
pub struct GenerateArguments {
    /// Shell completions, the man page, or a reference page
    #[arg(value_enum)]
    pub what: Product,
}

/// References that can be generated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Product {
    /// Completions for bash.
    Bash,
    /// Completions for elvish.
    Elvish,
    /// Completions for fish.
    Fish,
    /// The man page, in troff.
    Man,
    /// Completions for PowerShell.
    Powershell,
    /// All messages, in Markdown.
    ReferenceMessages,
    /// All keys of a scenario, in Markdown.
    ReferenceScenario,
    /// Completions for zsh.
    Zsh,
}

/// Runs the command; `program` is the whole command line.
pub fn run(arguments: &GenerateArguments, program: Command) -> Result<ExitCode, Error> {
    let text = match arguments.what {
        Product::Man => man(program),
        Product::ReferenceMessages => reference::messages_page(),
        Product::ReferenceScenario => reference::scenario_page(),
        Product::Bash => completions(Shell::Bash, program),
        Product::Elvish => completions(Shell::Elvish, program),
        Product::Fish => completions(Shell::Fish, program),
        Product::Powershell => completions(Shell::PowerShell, program),
        Product::Zsh => completions(Shell::Zsh, program),
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
