//! `timegap list`: what there is to run.

use crate::cli::ListArguments;
use crate::error::Error;
use controller::laws;
use shared::scenario::builtin;
use shared::scenario::controller::ControllerName;
use std::process::ExitCode;

/// Runs the command.
pub fn run(arguments: &ListArguments) -> Result<ExitCode, Error> {
    if let Some(name) = &arguments.show {
        let found = builtin::ALL.iter().find(|builtin| builtin.name == name);
        let builtin = found.ok_or_else(|| {
            let names: Vec<_> = builtin::ALL.iter().map(|builtin| builtin.name).collect();
            Error::Usage(format!(
                "no built-in scenario `{name}`, expected one of {}",
                names.join(", ")
            ))
        })?;
        print!("{}", builtin.text);
        return Ok(ExitCode::SUCCESS);
    }
    let scenarios = builtin::ALL.iter().map(|builtin| (builtin.name, builtin.summary));
    let controllers =
        ControllerName::ALL.into_iter().map(|name| (name.as_str(), laws::describe(name)));
    if arguments.json {
        let entry = |(name, line)| serde_json::json!({"name": name, "description": line});
        let list = serde_json::json!({
            "schema_version": 1,
            "scenarios": scenarios.map(entry).collect::<Vec<_>>(),
            "controllers": controllers.map(entry).collect::<Vec<_>>(),
        });
        println!("{}", serde_json::to_string_pretty(&list).expect("plain data"));
        return Ok(ExitCode::SUCCESS);
    }
    println!("Scenarios (timegap run NAME; timegap list --show NAME prints the file):");
    scenarios.for_each(|(name, line)| println!("  {name:<18} {line}"));
    println!("Controllers (timegap run --controller NAME):");
    controllers.for_each(|(name, line)| println!("  {name:<18} {line}"));
    Ok(ExitCode::SUCCESS)
}
