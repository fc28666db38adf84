//! Bodies of entities.

use crate::declare::{AtLeastZero, Node, Number, elements, scalars};
use crate::model::Body;

const MAX_EXTENT_M: f64 = 100.0;

scalars! {
    /// An extent of a body.
    Extent -> f64: format!("more than 0 and at most {MAX_EXTENT_M}; or 0 for both: unknown"),
        |given| given.number(&Self::kind(), |metres| (0.0..=MAX_EXTENT_M).contains(&metres));
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
    |node| {
        match (length_m == 0.0, width_m == 0.0) {
            (true, false) => Err(node.wrong("length", "0 is out of range", "more than 0")),
            (false, true) => Err(node.wrong("width", "0 is out of range", "more than 0")),
            _ => Ok((length_m, width_m)),
        }
    }
}

/// The body of a catalog's entry or of an entity. Files for players with models of their own leave the size away.
pub(super) fn sized(node: Node<'_>, body: Body, length_m: f64, width_m: f64) -> Body {
    if body.length_m > 0.0 {
        return body;
    }
    node.scene.notice(format!(
        "{}: the bounding box has no size: {length_m} m by {width_m} m is assumed",
        node.place()
    ));
    Body { length_m, width_m, ..body }
}
