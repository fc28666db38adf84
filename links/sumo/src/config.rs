//! A configuration file: the net and the demand that it names.

use std::path::{Path, PathBuf};

use openscenario::xml::Element;

use crate::ReadError;
use crate::net::Source;

/// The files of a configuration.
pub struct Config {
    pub net: PathBuf,
    /// Route files, then additional files, which may have routes as well.
    pub demand: Vec<PathBuf>,
}

impl Config {
    /// Reads a configuration. Relative paths in it start at its directory.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let source = Source::read(path)?;
        let directory = path.parent().unwrap_or(Path::new(""));
        let files = |names: &[&str]| -> Vec<PathBuf> {
            let value = option(&source.root, names).unwrap_or_default();
            let files = value.split(',').map(str::trim).filter(|file| !file.is_empty());
            files.map(|file| directory.join(file)).collect()
        };
        let is_configuration = matches!(
            source.root.name.as_str(),
            "configuration" | "sumoConfiguration" | "sumo-configuration"
        );
        if !is_configuration {
            let reason = format!("the outermost element is `{}`", source.root.name);
            let expected = "`configuration` or `sumoConfiguration`: a configuration file of SUMO";
            return Err(source.refuse(&source.root, reason, expected));
        }
        let Some(net) = files(&["net-file", "n", "net"]).into_iter().next() else {
            let expected = "<net-file value=\"NET.net.xml\"/> in `input`";
            return Err(source.refuse(&source.root, "no net file", expected));
        };
        let mut demand = files(&["route-files", "r", "routes"]);
        demand.extend(files(&["additional-files", "a", "additional"]));
        Ok(Self { net, demand })
    }
}

/// The value of an option, in whichever section it stands.
fn option<'a>(root: &'a Element, names: &[&str]) -> Option<&'a str> {
    let below =
        root.children.iter().flat_map(|section| std::iter::once(section).chain(&section.children));
    let mut named = below.filter(|element| names.contains(&element.name.as_str()));
    named.find_map(|element| element.attribute("value").or_else(|| element.attribute("v")))
}
