//! Bodies of entities.

use crate::declare::{AtLeastZero, Given, Number, Scalar, elements};
use crate::error::ReadError;
use crate::model::Body;

/// Largest extent of a body, m.
const MAX_EXTENT_M: f64 = 100.0;

/// An extent of a body.
struct Extent;

impl Scalar for Extent {
    type Value = f64;

    fn kind() -> String {
        format!("more than 0 and at most {MAX_EXTENT_M}")
    }

    fn take(given: &Given<'_>) -> Result<f64, ReadError> {
        given.number(&Self::kind(), |metres| metres > 0.0 && metres <= MAX_EXTENT_M)
    }
}

elements! { "Entities";
    /// extent of the body, for gaps, contact and the radar
    BoundingBox -> Body [] {center: Center, dimensions: Dimensions}
    {
        let ((center_ahead_m, center_left_m), (length_m, width_m)) = (center, dimensions);
        Ok(Body { center_ahead_m, center_left_m, length_m, width_m })
    }

    /// centre of the box, seen from the entity's origin
    Center -> (f64, f64) ["x" ahead_m: Number as "m", "y" left_m: Number as "m"] {} unused ["z"]
    { Ok((ahead_m, left_m)) }

    /// size of the box
    Dimensions -> (f64, f64)
    ["width" width_m: Extent as "m", "length" length_m: Extent as "m", "height" _: AtLeastZero as "m"]
    {}
    { Ok((length_m, width_m)) }
}
