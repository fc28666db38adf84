//! `timegap list`: scenarios, controllers and campaigns; `timegap print`: what accompanies the command.

use super::reference;
use clap::{Args, Command, Subcommand, ValueEnum};
use clap_complete::Shell;
use controller::law::{Descriptor, Formulation};
use controller::laws;
use report::print;
use report::results::schema_document;
use scenario::builtin;
use scenario::schema::Key;
use std::process::ExitCode;
use supervise::{Error, ScenarioOptions, UsageError};

#[derive(Debug, Args)]
pub struct ListArguments {
    /// Print a built-in scenario's or campaign's file, or an OpenSCENARIO file as a scenario
    #[arg(long, value_name = "NAME")]
    pub show: Option<String>,
    /// Set a parameter of the OpenSCENARIO file (repeatable)
    #[arg(long = "param", value_name = "NAME=VALUE", requires = "show")]
    pub parameters: Vec<String>,
    /// Name of the entity that is the ego, for --show FILE.xosc
    #[arg(long, value_name = "NAME", requires = "show")]
    pub ego: Option<String>,
    /// Print the list as JSON
    #[arg(long, conflicts_with = "show")]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct SchemaArguments {
    /// The scenario file, or the results of the commands
    #[arg(value_enum, default_value_t = SchemaOf::Scenario)]
    of: SchemaOf,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SchemaOf {
    /// The scenario file.
    Scenario,
    /// The results of the commands.
    Results,
}

/// The schemas of all results: one row a command.
fn results() -> serde_json::Value {
    let all = [
        grid::compare::schema(),
        grid::sweep::schema(),
        search::schema(),
        string::schema(),
        standards::r157::schema(),
        standards::iso15622::schema(),
        papers::schema(),
        bench::schema(),
        graph::schema(),
        campaign::schema(),
    ];
    schema_document(&[&all[..], &populations::schemas()].concat())
}

pub fn print_schema(arguments: &SchemaArguments) -> Result<ExitCode, Error> {
    let schema = match arguments.of {
        SchemaOf::Scenario => reference::json_schema(),
        SchemaOf::Results => results(),
    };
    let schema = serde_json::to_string_pretty(&schema).expect("plain data");
    print::out(&(schema + "\n"))?;
    Ok(ExitCode::SUCCESS)
}

pub fn run(arguments: &ListArguments, command: &clap::Command) -> Result<ExitCode, Error> {
    if let Some(name) = arguments.show.as_deref().filter(|name| supervise::is_openscenario(name)) {
        let parameters = arguments.parameters.clone();
        let ego = arguments.ego.clone();
        let options = ScenarioOptions { parameters, ego, ..ScenarioOptions::default() };
        print::out(&supervise::open(name, &options)?.to_toml())?;
        return Ok(ExitCode::SUCCESS);
    }
    let parameter = arguments.parameters.first().map(|it| ("--param", "parameters", it));
    let ego = arguments.ego.as_ref().map(|it| ("--ego", "entities", it));
    if let (Some(name), Some((option, what, argument))) = (&arguments.show, parameter.or(ego)) {
        let why = format!("{name} is not an OpenSCENARIO file and has no {what}");
        return Err(UsageError::option(option, argument, why, "--show FILE.xosc").into());
    }
    if let Some(name) = &arguments.show {
        let scenarios = builtin::ALL.iter().map(|builtin| (builtin.name, builtin.text));
        let campaigns = campaign::BUILTIN.into_iter();
        let files: Vec<_> = scenarios.chain(campaigns).collect();
        let found = files.iter().find(|(known, _)| known == name);
        let (_, text) = found.ok_or_else(|| {
            let names = scenario::accepted(name, files.iter().map(|(known, _)| *known));
            let why = "no scenario or campaign of this name";
            UsageError::option("--show", name, why, format!("one of {names}"))
        })?;
        print::out(text)?;
        return Ok(ExitCode::SUCCESS);
    }
    let line = |name: &str, about: &str| (name.to_owned(), about.to_owned());
    let scenarios = builtin::ALL.iter().map(|builtin| line(builtin.name, builtin.summary()));
    let laws = laws::ALL.iter().map(|law| line(law.name, law.description));
    let campaigns = campaign::summaries().map(|(name, about)| line(name, &about));
    let tests = command.find_subcommand("test").into_iter();
    let about =
        |test: &clap::Command| test.get_about().map(ToString::to_string).unwrap_or_default();
    let tests = tests.flat_map(clap::Command::get_subcommands);
    let tests = tests.map(|test| line(test.get_name(), &about(test)));
    let run = "timegap run NAME; timegap list --show NAME prints the file";
    let lists: [(&str, &str, Vec<_>); 4] = [
        ("Scenarios", run, scenarios.collect()),
        ("Controllers", "timegap run --controller NAME", laws.collect()),
        ("Campaigns", "timegap campaign NAME", campaigns.collect()),
        ("Tests", "timegap test NAME", tests.collect()),
    ];
    if arguments.json {
        let mut list = serde_json::json!({"schema_version": 1});
        for (title, _, rows) in lists {
            let entry = |(name, line)| serde_json::json!({"name": name, "description": line});
            list[title.to_lowercase()] = rows.into_iter().map(entry).collect();
        }
        list["controllers"] = laws::ALL.iter().copied().map(controller).collect();
        let json = serde_json::to_string_pretty(&list).expect("plain data");
        print::out(&(json + "\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut text = String::new();
    for (title, command, rows) in &lists {
        text.push_str(&format!("{title} ({command}):\n"));
        rows.iter().for_each(|(name, about)| text.push_str(&format!("  {name:<26} {about}\n")));
    }
    print::out(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn defaults(keys: &[Key]) -> toml::Table {
    keys.iter().filter_map(|key| Some((key.name.clone(), key.default.clone()?))).collect()
}

fn controller(law: &Descriptor) -> serde_json::Value {
    let formulation = |formulation: &&Formulation| {
        serde_json::json!({
            "name": formulation.name,
            "modes": formulation.modes,
            "reasons": formulation.reasons,
            "figures": formulation.figures,
        })
    };
    serde_json::json!({
        "name": law.name,
        "description": law.description,
        "source": law.source,
        "table": law.table.map(|table| table.name),
        "defaults": law.table.map(|table| defaults(&(table.keys)())),
        "formulations": law.formulations.iter().map(formulation).collect::<Vec<_>>(),
    })
}

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
pub fn generate(what: &Generated, mut program: Command) -> Result<ExitCode, Error> {
    let mut text = Vec::new();
    match what {
        Generated::Man => {
            clap_mangen::Man::new(program).render(&mut text).expect("memory takes all");
        }
        Generated::Reference { page: Page::Messages } => text = reference::messages_page().into(),
        Generated::Reference { page: Page::Scenario } => text = reference::scenario_page().into(),
        Generated::Completions { shell } => {
            clap_complete::generate(*shell, &mut program, "timegap", &mut text);
        }
    }
    print::out(&String::from_utf8(text).expect("our names are text"))?;
    Ok(ExitCode::SUCCESS)
}
