//! A net file: edges with lanes, and the connections between them.

use std::collections::HashMap;
use std::fmt::Display;
use std::fs::File;
use std::io::Read;

use flate2::read::MultiGzDecoder;
use openscenario::xml::{self, Element};

use crate::ReadError;

/// Longest file, bytes: a net of a large town.
const MOST_BYTES: usize = 256 << 20;

/// A file in memory, with its name in errors.
pub struct Source {
    pub name: String,
    pub root: Element,
}

impl Source {
    /// Reads an XML file, which may be compressed (`.gz`).
    pub fn read(path: &std::path::Path) -> Result<Self, ReadError> {
        let name = path.display().to_string();
        let refuse = |reason: String| ReadError(format!("{name}: {reason}"));
        let opened = |error| refuse(format!("cannot be opened: {error}"));
        // Looked at before it is opened: to open a pipe is to wait for its other end.
        if !path.metadata().map_err(opened)?.is_file() {
            return Err(refuse("is not a regular file".to_owned()));
        }
        let file = File::open(path).map_err(opened)?;
        let whole: Box<dyn Read> = match name.ends_with(".gz") {
            true => Box::new(MultiGzDecoder::new(file)),
            false => Box::new(file),
        };
        let mut text = String::new();
        let read = whole.take(MOST_BYTES as u64 + 1).read_to_string(&mut text);
        read.map_err(|error| refuse(format!("cannot be read: {error}")))?;
        let root = xml::parse_within(&name, &text, MOST_BYTES)?.root;
        Ok(Self { name, root })
    }

    /// An error about an element.
    pub fn refuse(
        &self,
        element: &Element,
        reason: impl Display,
        expected: impl Display,
    ) -> ReadError {
        ReadError::at(format_args!("{}:{}", self.name, element.spot), reason, expected)
    }

    /// The text of an attribute that must be there.
    pub fn text<'a>(&self, element: &'a Element, name: &str) -> Result<&'a str, ReadError> {
        element.attribute(name).ok_or_else(|| {
            let reason = format!("`{}` has no attribute `{name}`", element.name);
            self.refuse(element, reason, format!("`{name}`"))
        })
    }

    /// The number of an attribute; `otherwise` where it is not given.
    pub fn number(
        &self,
        element: &Element,
        name: &str,
        otherwise: Option<f64>,
    ) -> Result<f64, ReadError> {
        let text = match (element.attribute(name), otherwise) {
            (None, Some(value)) => return Ok(value),
            _ => self.text(element, name)?,
        };
        text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| {
            let reason = format!("{name}=\"{text}\" of `{}`", element.name);
            self.refuse(element, reason, "a finite number")
        })
    }
}

/// Width of a lane without one of its own, m: SUMO's.
const LANE_WIDTH_M: f64 = 3.2;

/// A lane of an edge.
#[derive(Clone, Debug)]
pub struct Lane {
    pub speed_mps: f64,
    pub width_m: f64,
    /// Its middle, in the direction of its traffic.
    pub shape: Vec<[f64; 2]>,
    /// Cars may use it.
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

/// The net.
pub struct Net {
    pub file: String,
    /// All edges, those inside of junctions too.
    pub edges: HashMap<String, Vec<Lane>>,
    /// The connections by the edge that they leave.
    pub connections: HashMap<String, Vec<Connection>>,
}

impl Net {
    /// Reads a net file.
    pub fn read(path: &std::path::Path) -> Result<Self, ReadError> {
        let source = Source::read(path)?;
        if source.root.name != "net" {
            let reason = format!("the outermost element is `{}`", source.root.name);
            return Err(source.refuse(&source.root, reason, "`net`: a net file of SUMO"));
        }
        let (mut edges, mut connections) = (HashMap::new(), HashMap::<String, Vec<_>>::new());
        for element in &source.root.children {
            match element.name.as_str() {
                "edge" => {
                    let lanes = element.children.iter().filter(|child| child.name == "lane");
                    let lanes = lanes.map(|lane| read_lane(&source, lane));
                    let id = source.text(element, "id")?.to_owned();
                    edges.insert(id, lanes.collect::<Result<Vec<_>, _>>()?);
                }
                "connection" => {
                    let from = source.text(element, "from")?.to_owned();
                    connections.entry(from).or_default().push(read_connection(&source, element)?);
                }
                _ => {}
            }
        }
        Ok(Self { file: source.name, edges, connections })
    }

    /// A lane by its id, inside of a junction: `EDGE_INDEX`.
    pub fn lane(&self, id: &str) -> Option<(&str, usize, &Lane)> {
        let (edge, index) = id.rsplit_once('_')?;
        let index: usize = index.parse().ok()?;
        let (edge, lanes) = self.edges.get_key_value(edge)?;
        Some((edge, index, lanes.get(index)?))
    }

    /// The connections from an edge.
    pub fn leaving(&self, edge: &str) -> &[Connection] {
        self.connections.get(edge).map_or(&[], Vec::as_slice)
    }
}

fn read_lane(source: &Source, element: &Element) -> Result<Lane, ReadError> {
    let text = source.text(element, "shape")?;
    let point = |point: &str| {
        let mut numbers = point.split(',').map(|number| number.parse::<f64>());
        match (numbers.next(), numbers.next()) {
            (Some(Ok(x)), Some(Ok(y))) if x.is_finite() && y.is_finite() => Some([x, y]),
            _ => None,
        }
    };
    let shape: Option<Vec<_>> = text.split_whitespace().map(point).collect();
    let shape = shape.filter(|shape| shape.len() > 1).ok_or_else(|| {
        source.refuse(element, "the shape of this lane", "two or more points x,y of finite numbers")
    })?;
    let speed_mps = source.number(element, "speed", None)?;
    let width_m = source.number(element, "width", Some(LANE_WIDTH_M))?;
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

fn read_connection(source: &Source, element: &Element) -> Result<Connection, ReadError> {
    let index = |name: &str| {
        let text = source.text(element, name)?;
        let refuse = |_| source.refuse(element, format!("{name}=\"{text}\""), "a whole number");
        text.parse::<usize>().map_err(refuse)
    };
    let light =
        element.attribute("tl").map(|id| index("linkIndex").map(|link| (id.to_owned(), link)));
    Ok(Connection {
        from_lane: index("fromLane")?,
        to: source.text(element, "to")?.to_owned(),
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
