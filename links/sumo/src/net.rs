//! A configuration file, and the net that it names: edges with lanes, and the connections between them.

use std::collections::HashMap;
use std::fmt::Display;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;
use openscenario::ReadError;
use openscenario::road::Text;
use openscenario::xml::{self, Document, Element};

/// Longest file, bytes: a net of a large town.
const MOST_BYTES: usize = 256 << 20;

/// Reads an XML file, which may be compressed (`.gz`).
pub fn document(path: &Path) -> Result<Document, ReadError> {
    let file = path.display().to_string();
    let refuse = |reason: String| ReadError::File { file: file.clone(), reason };
    let opened = |error| refuse(format!("cannot be opened: {error}"));
    // Looked at before it is opened: to open a pipe is to wait for its other end.
    if !path.metadata().map_err(opened)?.is_file() {
        return Err(refuse("is not a regular file".to_owned()));
    }
    let packed = File::open(path).map_err(opened)?;
    let whole: Box<dyn Read> = match file.ends_with(".gz") {
        true => Box::new(MultiGzDecoder::new(packed)),
        false => Box::new(packed),
    };
    let mut text = String::new();
    let read = whole.take(MOST_BYTES as u64 + 1).read_to_string(&mut text);
    read.map_err(|error| refuse(format!("cannot be read: {error}")))?;
    xml::parse_within(&file, &text, MOST_BYTES)
}

/// The value of an attribute that must be there.
fn given<'a>(file: Text<'_>, element: &'a Element, name: &str) -> Result<&'a str, ReadError> {
    element.attribute(name).ok_or_else(|| {
        let reason = format!("`{}` has no attribute `{name}`", element.name);
        file.meaning(element, reason, format!("`{name}`"))
    })
}

/// The net of a configuration, and its route files with the additional files, which may have routes as well. Relative
/// paths start at the directory of the configuration.
pub fn configured(path: &Path) -> Result<(PathBuf, Vec<PathBuf>), ReadError> {
    let Document { file, root } = document(path)?;
    let source = Text { file: &file };
    if !["configuration", "sumoConfiguration", "sumo-configuration"].contains(&&*root.name) {
        let reason = format!("the outermost element is `{}`", root.name);
        let expected = "`configuration` or `sumoConfiguration`: a configuration file of SUMO";
        return Err(source.meaning(&root, reason, expected));
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
        return Err(source.meaning(&root, "no net file", expected));
    };
    let routes = files(["route-files", "r", "routes"]);
    Ok((net, [routes, files(["additional-files", "a", "additional"])].concat()))
}

/// Names that an error lists.
const LISTED: usize = 8;
/// Width of a lane without one of its own, m: SUMO's.
const LANE_WIDTH_M: f64 = 3.2;

#[derive(Clone, Debug)]
pub struct Lane {
    pub speed_mps: f64,
    pub width_m: f64,
    /// Its middle, in the direction of its traffic.
    pub shape: Vec<[f64; 2]>,
    pub drivable: bool,
}

/// A connection from a lane to one of another edge.
#[derive(Clone, Debug)]
pub struct Connection {
    pub from_lane: usize,
    pub to: String,
    pub to_lane: usize,
    /// The lane inside the junction.
    pub via: Option<String>,
    /// Its light: the controller's id, and its place in the state.
    pub light: Option<(String, usize)>,
    /// It gives way to others, by its state.
    pub yields: bool,
}

pub struct Net {
    pub file: String,
    /// All edges, those inside of junctions too.
    pub edges: HashMap<String, Vec<Lane>>,
    /// The connections by the edge that they leave.
    pub connections: HashMap<String, Vec<Connection>>,
}

impl Net {
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let Document { file, root } = document(path)?;
        let source = Text { file: &file };
        if root.name != "net" {
            let reason = format!("the outermost element is `{}`", root.name);
            return Err(source.meaning(&root, reason, "`net`: a net file of SUMO"));
        }
        let (mut edges, mut connections) = (HashMap::new(), HashMap::<String, Vec<_>>::new());
        for element in &root.children {
            match element.name.as_str() {
                "edge" => {
                    let lanes = element.children.iter().filter(|child| child.name == "lane");
                    let lanes = lanes.map(|lane| read_lane(source, lane));
                    let id = given(source, element, "id")?.to_owned();
                    edges.insert(id, lanes.collect::<Result<Vec<_>, _>>()?);
                }
                "connection" => {
                    let from = given(source, element, "from")?.to_owned();
                    connections.entry(from).or_default().push(read_connection(source, element)?);
                }
                _ => {}
            }
        }
        Ok(Self { file, edges, connections })
    }

    pub fn refuse(&self, reason: impl Display, expected: impl Display) -> ReadError {
        let reason = format!("{reason}, expected {expected}");
        ReadError::File { file: self.file.clone(), reason }
    }

    /// The lanes of an edge between junctions.
    pub fn lanes(&self, edge: &str) -> Result<&[Lane], ReadError> {
        let is_open = |id: &&String| !id.starts_with(':');
        let lanes = self.edges.get_key_value(edge).filter(|(id, _)| is_open(id));
        lanes.map(|(_, lanes)| lanes.as_slice()).ok_or_else(|| {
            let mut known: Vec<_> = self.edges.keys().filter(is_open).collect();
            known.sort_unstable();
            let expected = format!("one of {}", listed(&known));
            self.refuse(format!("the net has no edge `{edge}`"), expected)
        })
    }

    /// A lane by its id, inside of a junction: `EDGE_INDEX`.
    pub fn lane(&self, id: &str) -> Option<(&str, usize, &Lane)> {
        let (edge, index) = id.rsplit_once('_')?;
        let index: usize = index.parse().ok()?;
        let (edge, lanes) = self.edges.get_key_value(edge)?;
        Some((edge, index, lanes.get(index)?))
    }

    pub fn leaving(&self, edge: &str) -> &[Connection] {
        self.connections.get(edge).map_or(&[], Vec::as_slice)
    }
}

/// The first of these names, for an error.
pub fn listed(names: &[impl AsRef<str>]) -> String {
    let some: Vec<_> = names.iter().take(LISTED).map(|id| format!("`{}`", id.as_ref())).collect();
    format!("{}{}", some.join(", "), if names.len() > LISTED { ", .." } else { "" })
}

fn read_lane(source: Text<'_>, element: &Element) -> Result<Lane, ReadError> {
    let text = given(source, element, "shape")?;
    let point = |point: &str| {
        let mut numbers = point.split(',').map(|number| number.parse::<f64>());
        match (numbers.next(), numbers.next()) {
            (Some(Ok(x)), Some(Ok(y))) if x.is_finite() && y.is_finite() => Some([x, y]),
            _ => None,
        }
    };
    let shape: Option<Vec<_>> = text.split_whitespace().map(point).collect();
    let shape = shape.filter(|shape| shape.len() > 1).ok_or_else(|| {
        source.meaning(
            element,
            "the shape of this lane",
            "two or more points x,y of finite numbers",
        )
    })?;
    let speed_mps = source.number(element, "speed")?;
    let width_m = match element.attribute("width") {
        Some(_) => source.number(element, "width")?,
        None => LANE_WIDTH_M,
    };
    let word = |name: &str, class: &str| {
        let classes = element.attribute(name).unwrap_or_default();
        classes.split_whitespace().any(|one| one == class || one == "all")
    };
    let allows = element.attribute("allow").is_none_or(|_| word("allow", "passenger"));
    Ok(Lane {
        speed_mps,
        width_m: if width_m > 0.0 { width_m } else { LANE_WIDTH_M },
        shape,
        drivable: allows && !word("disallow", "passenger"),
    })
}

fn read_connection(source: Text<'_>, element: &Element) -> Result<Connection, ReadError> {
    let index = |name: &str| {
        let index = usize::try_from(source.whole(element, name)?);
        index.map_err(|_| source.meaning(element, format!("a negative `{name}`"), "at least 0"))
    };
    let light =
        element.attribute("tl").map(|id| index("linkIndex").map(|link| (id.to_owned(), link)));
    Ok(Connection {
        from_lane: index("fromLane")?,
        to: given(source, element, "to")?.to_owned(),
        to_lane: index("toLane")?,
        via: element.attribute("via").map(str::to_owned),
        light: light.transpose()?,
        yields: matches!(element.attribute("state"), Some("m" | "s" | "w" | "Z")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::{Compression, GzBuilder};
    use std::io::Write;

    #[test]
    fn a_compressed_net_is_read_and_a_cut_one_refused() {
        let path = std::env::temp_dir().join(format!("{}.net.xml.gz", std::process::id()));
        let net =
            "<net><edge id=\"a\"><lane id=\"a_0\" speed=\"9\" shape=\"0,0 9,0\"/></edge></net>";
        let mut packed = GzBuilder::new().write(Vec::new(), Compression::fast());
        packed.write_all(net.as_bytes()).expect("memory");
        let packed = packed.finish().expect("memory");
        std::fs::write(&path, &packed).expect("writable");
        assert_eq!(Net::read(&path).expect("a net").edges["a"][0].speed_mps, 9.0);
        std::fs::write(&path, &packed[..packed.len() / 2]).expect("writable");
        let refused = Net::read(&path).err().expect("cut").to_string();
        assert!(refused.contains("cannot be read"), "{refused}");
        std::fs::remove_file(&path).expect("ours");
    }
}
