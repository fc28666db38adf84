//! Pieces as a person writes them: a spiral takes its curvatures from its neighbours.

use crate::{AxisError, Piece};

/// A part of a road. A spiral joins what stands on its two sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Element {
    /// A straight line.
    Line {
        /// Length, m.
        length_m: f64,
    },
    /// An arc.
    Arc {
        /// Length, m.
        length_m: f64,
        /// Curvature, 1/m, positive to the left.
        curvature_perm: f64,
    },
    /// A clothoid from the curvature before to the curvature behind.
    Spiral {
        /// Length, m.
        length_m: f64,
    },
}

impl Element {
    /// The curvature that it gives its neighbours, 1/m.
    fn curvature_perm(&self) -> Option<f64> {
        match *self {
            Self::Line { .. } => Some(0.0),
            Self::Arc { curvature_perm, .. } => Some(curvature_perm),
            Self::Spiral { .. } => None,
        }
    }
}

/// The pieces of a list of elements.
///
/// ```
/// use road::{Element, Piece, joined};
/// let pieces = joined(&[
///     Element::Line { length_m: 300.0 },
///     Element::Spiral { length_m: 80.0 },
///     Element::Arc { length_m: 400.0, curvature_perm: 0.002 },
/// ])?;
/// assert_eq!(pieces[1], Piece::Spiral { length_m: 80.0, start_perm: 0.0, end_perm: 0.002 });
/// # Ok::<(), road::AxisError>(())
/// ```
///
/// # Errors
/// When a spiral stands at an end or beside another spiral.
pub fn joined(elements: &[Element]) -> Result<Vec<Piece>, AxisError> {
    let beside = |index: Option<usize>, piece: usize| {
        let element = index.and_then(|index| elements.get(index));
        element.and_then(Element::curvature_perm).ok_or(AxisError::Spiral { piece })
    };
    let piece = |(i, element): (usize, &Element)| {
        Ok(match *element {
            Element::Line { length_m } => Piece::Line { length_m },
            Element::Arc { length_m, curvature_perm } => Piece::Arc { length_m, curvature_perm },
            Element::Spiral { length_m } => Piece::Spiral {
                length_m,
                start_perm: beside(i.checked_sub(1), i)?,
                end_perm: beside(Some(i + 1), i)?,
            },
        })
    };
    elements.iter().enumerate().map(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spiral_needs_a_curvature_on_both_sides() {
        let (line, spiral) = (Element::Line { length_m: 9.0 }, Element::Spiral { length_m: 9.0 });
        for (elements, piece) in [
            (vec![spiral, line], 0),
            (vec![line, spiral], 1),
            (vec![line, spiral, spiral, line], 1),
        ] {
            assert_eq!(joined(&elements), Err(AxisError::Spiral { piece }));
        }
    }
}
