//! A configuration file: the net and the demand that it names.

use std::path::{Path, PathBuf};

use crate::ReadError;
use crate::net::Source;

/// The net of a configuration, and its route files with the additional files, which may have routes as well. Relative
/// paths start at the directory of the configuration.
pub fn read(path: &Path) -> Result<(PathBuf, Vec<PathBuf>), ReadError> {
    let source = Source::read(path)?;
    let root = &source.root;
    if !["configuration", "sumoConfiguration", "sumo-configuration"].contains(&&*root.name) {
        let reason = format!("the outermost element is `{}`", root.name);
        let expected = "`configuration` or `sumoConfiguration`: a configuration file of SUMO";
        return Err(source.refuse(root, reason, expected));
    }
    let directory = path.parent().unwrap_or(Path::new(""));
    // An option may stand in any section.
    let files = |names: [&str; 3]| -> Vec<PathBuf> {
        let below =
            root.children.iter().flat_map(|section| [section].into_iter().chain(&section.children));
        let mut named = below.filter(|element| names.contains(&&*element.name));
        let value = named.find_map(|one| one.attribute("value").or_else(|| one.attribute("v")));
        let files = value.unwrap_or_default().split(',').map(str::trim);
        files.filter(|file| !file.is_empty()).map(|file| directory.join(file)).collect()
    };
    let Some(net) = files(["net-file", "n", "net"]).into_iter().next() else {
        let expected = "<net-file value=\"NET.net.xml\"/> in `input`";
        return Err(source.refuse(root, "no net file", expected));
    };
    let routes = files(["route-files", "r", "routes"]);
    Ok((net, [routes, files(["additional-files", "a", "additional"])].concat()))
}
