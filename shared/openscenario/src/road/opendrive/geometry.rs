//! `planView`: the reference line.

use road::{Axis, Laid, MAX_GAP_M, Piece, Pose};

use super::text::{Text, children};
use crate::error::ReadError;
use crate::xml::Element;

/// Share by which a cubic's declared length may differ from its true one without a notice.
const NOTICED: f64 = 0.01;

pub struct Line<'a> {
    pub pieces: Vec<Laid>,
    pub length_m: f64,
    elements: Vec<&'a Element>,
    pub notices: Vec<String>,
}

impl<'a> Line<'a> {
    pub fn read(text: Text<'_>, road: &'a Element) -> Result<Self, ReadError> {
        let declared_m = text.number(road, "length")?;
        if !(declared_m > 0.0) {
            return Err(text.meaning(road, "the road has no length", "a length"));
        }
        let view = road.child("planView");
        let elements: Vec<&Element> =
            view.map(|view| children(view, "geometry").collect()).unwrap_or_default();
        if elements.is_empty() {
            return Err(text.element(road, "OpenDRIVE", "has no geometry", "`planView`"));
        }
        let mut line =
            Line { pieces: Vec::new(), length_m: 0.0, elements: Vec::new(), notices: Vec::new() };
        for element in elements {
            line.add(text, element)?;
        }
        if (line.length_m - declared_m).abs() > MAX_GAP_M {
            let reason = format!(
                "the road is {declared_m} m long, its geometries are {:.3} m",
                line.length_m
            );
            return Err(text.meaning(road, reason, "the same length"));
        }
        Ok(line)
    }

    fn add(&mut self, text: Text<'_>, element: &'a Element) -> Result<(), ReadError> {
        let [s_m, x_m, y_m, heading_rad, length_m] =
            text.numbers(element, ["s", "x", "y", "hdg", "length"])?;
        if !(length_m > 0.0) {
            let reason = format!("a geometry of {length_m} m");
            return Err(text.meaning(element, reason, "a length above 0"));
        }
        if (s_m - self.length_m).abs() > MAX_GAP_M {
            let reason = format!(
                "the geometry begins at s = {s_m} m, the one before ends at {:.3} m",
                self.length_m
            );
            return Err(text.meaning(element, reason, "geometries without a gap"));
        }
        let piece = piece(text, element, length_m)?;
        let true_m = piece.true_length_m();
        if (true_m / length_m - 1.0).abs() > NOTICED {
            self.notices.push(format!(
                "{}: the geometry is declared {length_m} m long and is {true_m:.3} m: it is passed evenly",
                text.place(element)
            ));
        }
        let start = begin(&piece).placed(&Pose { x_m, y_m, heading_rad });
        self.pieces.push(Laid { start, piece });
        self.elements.push(element);
        self.length_m += length_m;
        Ok(())
    }

    pub fn axis(&self, text: Text<'_>, least_radius_m: f64) -> Result<Axis, ReadError> {
        Axis::laid(&self.pieces, least_radius_m).map_err(|error| {
            let element = self.elements[error.piece.min(self.elements.len() - 1)];
            text.meaning(element, error.to_string(), error.expected())
        })
    }

    pub fn reversed(&self) -> Vec<Laid> {
        let turned = |laid: &Laid| {
            let end = Axis::new(&[laid.piece]).map(|axis| axis.pose(laid.piece.length_m()));
            let end = end.unwrap_or_default().placed(&laid.start);
            let heading_rad = end.heading_rad + std::f64::consts::PI;
            Laid { start: Pose { heading_rad, ..end }, piece: laid.piece.reversed() }
        };
        self.pieces.iter().rev().map(turned).collect()
    }
}

fn piece(text: Text<'_>, element: &Element, length_m: f64) -> Result<Piece, ReadError> {
    const SHAPES: &str = "`line`, `arc`, `spiral`, `poly3` or `paramPoly3`";
    let is_shape = |child: &&Element| {
        matches!(child.name.as_str(), "line" | "arc" | "spiral" | "poly3" | "paramPoly3")
    };
    let Some(shape) = element.children.iter().find(is_shape) else {
        return Err(match element.children.first() {
            Some(other) => text.element(other, "geometry", "is not supported", SHAPES),
            None => text.element(element, "planView", "has no shape", SHAPES),
        });
    };
    let arc = |curvature_perm: f64| match curvature_perm == 0.0 {
        true => Piece::Line { length_m },
        false => Piece::Arc { length_m, curvature_perm },
    };
    Ok(match shape.name.as_str() {
        "line" => Piece::Line { length_m },
        "arc" => arc(text.number(shape, "curvature")?),
        "spiral" => {
            let [start_perm, end_perm] = text.numbers(shape, ["curvStart", "curvEnd"])?;
            match start_perm == end_perm {
                true => arc(start_perm),
                false => Piece::Spiral { length_m, start_perm, end_perm },
            }
        }
        "poly3" => Piece::Cubic { length_m, v: text.numbers(shape, ["a", "b", "c", "d"])? },
        _ => {
            let u = text.numbers(shape, ["aU", "bU", "cU", "dU"])?;
            let v = text.numbers(shape, ["aV", "bV", "cV", "dV"])?;
            // The standard's default is `normalized`.
            let end = match shape.attribute("pRange").unwrap_or("normalized") {
                "normalized" => 1.0,
                "arcLength" => length_m,
                other => {
                    let reason = format!("`pRange` is `{other}`");
                    return Err(text.meaning(shape, reason, "`arcLength` or `normalized`"));
                }
            };
            Piece::ParamCubic { length_m, u, v, end }
        }
    })
}

/// The first point and direction of a geometry in its own axes: a cubic may begin beside and across them.
fn begin(piece: &Piece) -> Pose {
    match *piece {
        Piece::Cubic { v, .. } => Pose { x_m: 0.0, y_m: v[0], heading_rad: libm::atan(v[1]) },
        Piece::ParamCubic { u, v, .. } => {
            Pose { x_m: u[0], y_m: v[0], heading_rad: libm::atan2(v[1], u[1]) }
        }
        Piece::Line { .. } | Piece::Arc { .. } | Piece::Spiral { .. } => Pose::default(),
    }
}
