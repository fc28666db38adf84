//! Mutated scenario files are refused in one error, or they move and stay finite.

#![allow(
    clippy::result_large_err,
    reason = "an error ends the reading of a file; its size costs nothing"
)]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use openscenario::variation::Variation;
use openscenario::{Disk, Source, World, read};
use quick_xml::XmlVersion;
use quick_xml::events::attributes::{AttrError, Attribute};
use quick_xml::events::{BytesStart, Event};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Mutations of each file in the ordinary test.
const MUTATIONS: u32 = 400;
/// Numbers that are likely to break arithmetic.
const NUMBERS: [&str; 15] = [
    "0", "-1", "1", "0.5", "2", "10", "100", "1e5", "1e9", "-1e9", "1e-320", "3.14159", "-0.0",
    "300", "-20",
];
/// Values that are likely to break a reader.
const VALUES: [&str; 14] = [
    "",
    "1e308",
    "INF",
    "-INF",
    "NaN",
    "true",
    "$x",
    "${1/0}",
    "${$Gap_m}",
    "${",
    "9999999999",
    "Ego",
    "linear",
    "é",
];

/// An element of a file.
#[derive(Clone)]
struct Element {
    name: String,
    attributes: Vec<(String, String)>,
    children: Vec<Element>,
}

impl Element {
    /// The outermost element of a text that is well-formed.
    fn parse(text: &str) -> Option<Self> {
        let of = |tag: &BytesStart<'_>| -> Option<Element> {
            let attribute = |attribute: Result<Attribute<'_>, AttrError>| {
                let attribute = attribute.ok()?;
                let value = attribute.normalized_value(XmlVersion::Implicit1_0).ok()?;
                Some((attribute.key.as_ref().to_owned(), value.into_owned()))
            };
            let attributes = tag.attributes().map(attribute).collect::<Option<_>>()?;
            Some(Element { name: tag.name().as_ref().to_owned(), attributes, children: Vec::new() })
        };
        let mut reader = quick_xml::Reader::from_str(text);
        let mut open: Vec<Element> = Vec::new();
        loop {
            let closed = match reader.read_event().ok()? {
                Event::Start(tag) => {
                    open.push(of(&tag)?);
                    continue;
                }
                Event::Empty(tag) => of(&tag)?,
                Event::End(_) => open.pop()?,
                Event::Eof => return None,
                _ => continue,
            };
            match open.last_mut() {
                Some(parent) => parent.children.push(closed),
                None => return Some(closed),
            }
        }
    }

    fn write(&self, text: &mut String) {
        *text += &format!("<{}", self.name);
        for (name, value) in &self.attributes {
            let value = quick_xml::escape::escape(value.as_str());
            *text += &format!(" {name}=\"{value}\"");
        }
        *text += ">";
        self.children.iter().for_each(|child| child.write(text));
        *text += &format!("</{}>\n", self.name);
    }

    fn count(&self) -> usize {
        1 + self.children.iter().map(Element::count).sum::<usize>()
    }

    /// The element with a number, in the order of the file.
    fn at(&mut self, mut number: usize) -> Option<&mut Element> {
        if number == 0 {
            return Some(self);
        }
        number -= 1;
        for child in &mut self.children {
            let count = child.count();
            if number < count {
                return child.at(number);
            }
            number -= count;
        }
        None
    }
}

/// A generator with the choices of a mutation.
struct Choices(Pcg64Mcg);

impl Choices {
    fn below(&mut self, count: usize) -> usize {
        self.0.next_u32() as usize % count.max(1)
    }

    fn element<'a>(&mut self, root: &'a mut Element) -> &'a mut Element {
        let number = self.below(root.count());
        root.at(number).expect("the number is below the count")
    }

    /// Changes one thing in a file; `donor` is another file.
    fn mutate(&mut self, root: &mut Element, donor: &mut Element) {
        let kind = self.below(12);
        let graft = self.element(donor).clone();
        let target = self.element(root);
        let (children, attributes) = (target.children.len(), target.attributes.len());
        match kind {
            0..=6 if attributes > 0 => {
                let (name, value) = &mut target.attributes[self.below(attributes)];
                let is_number = value.starts_with('$') || value.parse::<f64>().is_ok();
                let like = graft.attributes.iter().find(|(other, _)| other == name);
                *value = match (self.below(8), like) {
                    (0, _) => VALUES[self.below(VALUES.len())].to_owned(),
                    (_, Some((_, like))) => like.clone(),
                    (_, None) if is_number => NUMBERS[self.below(NUMBERS.len())].to_owned(),
                    _ => return,
                };
            }
            7 if attributes > 0 => drop(target.attributes.remove(self.below(attributes))),
            8 if children > 0 => drop(target.children.remove(self.below(children))),
            9 if children > 0 => {
                let again = target.children[self.below(children)].clone();
                target.children.insert(self.below(children), again);
            }
            10 if children > 0 => {
                let place = self.below(children);
                let like = donor_like(donor, &target.children[place].name);
                target.children[place] = like.unwrap_or(graft);
            }
            11 => target.name = graft.name,
            _ => target.children.push(graft),
        }
    }
}

/// The last element of a name in a file.
fn donor_like(donor: &Element, name: &str) -> Option<Element> {
    let inside = donor.children.iter().rev().find_map(|child| donor_like(child, name));
    inside.or_else(|| (donor.name == name).then(|| donor.clone()))
}

/// A file that stands in for one on the disk.
struct Changed<'a> {
    path: &'a Path,
    text: String,
}

impl Source for Changed<'_> {
    fn read(&self, path: &Path) -> std::io::Result<String> {
        if path == self.path { Ok(self.text.clone()) } else { Disk.read(path) }
    }

    fn list(&self, directory: &Path) -> std::io::Result<Vec<PathBuf>> {
        Disk.list(directory)
    }
}

/// Reads a file and moves it for 20 s beside an ego that keeps its speed. Whether it moved.
fn drive(files: &Changed<'_>) -> bool {
    let one_line = |said: String| assert!(!said.contains('\n') && said.len() < 4000, "{said}");
    if let Err(error) = Variation::open(files.path, files) {
        one_line(error.to_string());
    }
    let read = match read::scenario(files.path, files, &Default::default()) {
        Ok(read) => read,
        Err(error) => {
            one_line(error.to_string());
            return false;
        }
    };
    let entities = read.script.entities.len();
    assert_eq!((read.spots.entities.len(), read.spots.starts.len()), (entities, entities));
    let ego = read.script.ego;
    let Ok(mut world) = World::new(read.script) else { return false };
    let mut motion = world.motion(ego);
    for step in 0..200_u64 {
        world.observe(ego, motion);
        world.step(step * 100_000_000);
        motion.s_m += 0.1 * motion.speed_mps;
        for entity in 0..entities {
            let it = world.motion(entity);
            let position = [it.s_m, it.t_m, it.heading_rad];
            let speed = [it.speed_mps, it.lateral_mps, it.acceleration_mps2];
            let is_finite = position.iter().chain(&speed).all(|figure| figure.is_finite());
            assert!(is_finite && it.speed_mps >= 0.0, "step {step}: {it:?}\n{}", files.text);
        }
    }
    true
}

/// The example files, and those in the folders of `OPENSCENARIO_FILES`, separated by `:`.
fn files() -> Vec<(PathBuf, Element)> {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/openscenario");
    let more = std::env::var("OPENSCENARIO_FILES").unwrap_or_default();
    let mut open = vec![examples];
    open.extend(more.split(':').filter(|folder| !folder.is_empty()).map(PathBuf::from));
    let mut files = Vec::new();
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).expect("a readable folder") {
            let path = entry.expect("a readable folder").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "xosc") {
                let text = std::fs::read_to_string(&path).expect("a readable file");
                files.extend(Element::parse(&text).map(|root| (path, root)));
            }
        }
    }
    files.sort_by(|a, b| a.0.cmp(&b.0));
    files
}

/// Mutates each file, over and over until `done` says that it is enough. Number of files that moved, and of those with
/// a storyboard: catalogs and variations do not move.
fn mutate(seed: u64, done: impl Fn(u32) -> bool) -> (u32, u32) {
    let files = files();
    let mut choices = Choices(Pcg64Mcg::seed_from_u64(seed));
    let (mut moved, mut all) = (0, 0);
    for round in 0.. {
        if done(round) {
            break;
        }
        for (path, root) in &files {
            let mut donor = files[choices.below(files.len())].1.clone();
            let mut root = root.clone();
            for _ in 0..1 + choices.below(2) {
                choices.mutate(&mut root, &mut donor);
            }
            let mut text = String::new();
            root.write(&mut text);
            moved += u32::from(drive(&Changed { path, text }));
            all += u32::from(root.children.iter().any(|child| child.name == "Storyboard"));
        }
    }
    (moved, all)
}

#[test]
fn mutated_files_are_refused_or_move() {
    let (moved, all) = mutate(1, |round| round == MUTATIONS);
    assert!(moved > all / 10, "only {moved} of {all} files moved");
}

#[test]
#[ignore = "takes a minute"]
fn mutated_files_are_refused_or_move_for_a_minute() {
    let (start, seed) = (Instant::now(), std::process::id());
    let (moved, all) = mutate(seed.into(), |_| start.elapsed() > Duration::from_secs(60));
    println!("seed {seed}: {moved} of {all} files moved");
    assert!(moved > 0);
}
