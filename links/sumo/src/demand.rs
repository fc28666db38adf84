//! The ego's edges: those of a route, vehicle, trip or flow of the route files, or the quickest way between two edges.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::path::PathBuf;

use openscenario::road::Text;
use openscenario::xml::{Document, Element};

use crate::ReadError;
use crate::line::Line;
use crate::net::{Net, document, listed};

/// The edges that `ego` names: `NAME`, or `from=EDGE,to=EDGE`.
pub fn edges(ego: &str, net: &Net, files: &[PathBuf]) -> Result<Vec<String>, ReadError> {
    if let Some(ends) = ends(ego) {
        return quickest(net, &ends);
    }
    let mut known = Vec::new();
    for file in files {
        let document = document(file)?;
        for element in &document.root.children {
            let is_way = matches!(element.name.as_str(), "route" | "vehicle" | "trip" | "flow");
            match element.attribute("id").filter(|_| is_way) {
                Some(id) if id == ego => return of_element(element, &document, net),
                Some(id) => known.push(id.to_owned()),
                None => {}
            }
        }
    }
    let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
    let file = if names.is_empty() { net.file.clone() } else { names.join(", ") };
    let expected = match known.is_empty() {
        true => "from=EDGE,to=EDGE, for these files have no routes".to_owned(),
        false => format!("{} or from=EDGE,to=EDGE", listed(&known)),
    };
    let reason = format!("there is no route, vehicle, trip or flow `{ego}`, expected {expected}");
    Err(ReadError::File { file, reason })
}

/// The two edges of `from=EDGE,to=EDGE`, with those of `via=EDGE` between them.
fn ends(ego: &str) -> Option<Vec<String>> {
    let parts: Option<Vec<_>> = ego.split(',').map(|part| part.split_once('=')).collect();
    let parts = parts.filter(|parts| parts.len() > 1)?;
    let fits = |(place, (key, _)): (usize, &(&str, &str))| {
        matches!((place, key.trim()), (0, "from") | (1.., "via" | "to"))
    };
    let stops = parts.iter().map(|(_, edge)| edge.trim().to_owned());
    parts.iter().enumerate().all(fits).then(|| stops.collect())
}

fn of_element(element: &Element, file: &Document, net: &Net) -> Result<Vec<String>, ReadError> {
    let source = Text { file: &file.file };
    let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let inside = || element.child("route").and_then(|route| route.attribute("edges"));
    if let Some(edges) = element.attribute("edges").or_else(inside) {
        return Ok(words(edges));
    }
    if let Some(name) = element.attribute("route") {
        let mut all = file.root.children.iter();
        let found = all.find(|one| one.name == "route" && one.attribute("id") == Some(name));
        let edges = found.and_then(|route| route.attribute("edges"));
        let reason = format!("there is no route `{name}` in this file");
        let refuse = || source.meaning(element, reason, "one with edges");
        return edges.map(words).ok_or_else(refuse);
    }
    let (Some(from), Some(to)) = (element.attribute("from"), element.attribute("to")) else {
        let expected = "edges, a route, or from and to";
        return Err(source.meaning(element, "this way of the ego has no edges", expected));
    };
    let via = element.attribute("via").unwrap_or_default();
    quickest(net, &words(&format!("{from} {via} {to}")))
}

/// The quickest way over these edges, by the speed limits.
fn quickest(net: &Net, stops: &[String]) -> Result<Vec<String>, ReadError> {
    for edge in stops {
        net.lanes(edge)?;
    }
    let mut way = vec![stops[0].clone()];
    for pair in stops.windows(2) {
        let part = between(net, &pair[0], &pair[1]).ok_or_else(|| {
            let reason = format!("no way for cars leads from `{}` to `{}`", pair[0], pair[1]);
            net.refuse(reason, "two edges that connections join")
        })?;
        way.extend(part);
    }
    Ok(way)
}

/// The edges behind `from` on the quickest way to `to`: Dijkstra's algorithm over whole milliseconds.
fn between(net: &Net, from: &str, to: &str) -> Option<Vec<String>> {
    let cost_ms = |edge: &str| {
        let lanes = net.edges.get(edge)?.iter().filter(|lane| lane.drivable);
        let fastest = lanes.max_by(|a, b| a.speed_mps.total_cmp(&b.speed_mps))?;
        let way_m = Line::of(&fastest.shape).length_m();
        Some((1e3 * way_m / fastest.speed_mps.max(0.1)) as u64 + 1)
    };
    let mut best: HashMap<&str, (u64, Option<&str>)> = HashMap::from([(from, (0, None))]);
    let mut open = BinaryHeap::from([Reverse((0, from))]);
    while let Some(Reverse((so_far, edge))) = open.pop() {
        if edge == to && (so_far > 0 || from == to) {
            break;
        }
        if best.get(edge).is_some_and(|(known, _)| *known < so_far) {
            continue;
        }
        let lanes = &net.edges[edge];
        for next in net.leaving(edge) {
            let is_open = lanes.get(next.from_lane).is_some_and(|lane| lane.drivable);
            let Some(cost) = cost_ms(&next.to).filter(|_| is_open) else { continue };
            let reached = so_far + cost;
            if best.get(next.to.as_str()).is_none_or(|(known, _)| reached < *known) {
                best.insert(&next.to, (reached, Some(edge)));
                open.push(Reverse((reached, &next.to)));
            }
        }
    }
    let mut way = Vec::new();
    let mut at = to;
    while let Some((_, Some(before))) = best.get(at) {
        way.push(at.to_owned());
        at = before;
    }
    way.reverse();
    (at == from && (from == to || !way.is_empty())).then_some(way)
}
