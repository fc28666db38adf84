//! Reader of OpenDRIVE files.

use super::{Lane, Line, Road};
use crate::error::{Place, ReadError, one_of};
use crate::xml::{Document, Element};

/// Most roads that an error lists.
const MOST_LISTED: usize = 8;

/// Reads the road `id`, or the only one, from an OpenDRIVE file.
///
/// # Errors
/// When there is no such road, or its lanes change along it.
pub fn read(document: &Document, id: Option<&str>) -> Result<Road, ReadError> {
    let reader = Reader { file: &document.file };
    let root = &document.root;
    if root.name != "OpenDRIVE" {
        return Err(reader.element(root, "the file", "is not supported", "`OpenDRIVE`"));
    }
    let roads: Vec<&Element> = root.children.iter().filter(|e| e.name == "road").collect();
    let found = match (id, roads.as_slice()) {
        (Some(id), roads) => roads.iter().find(|road| road.attribute("id") == Some(id)).copied(),
        (None, [road]) => Some(*road),
        (None, _) => None,
    };
    let Some(road) = found else {
        let ids = roads.iter().filter_map(|road| road.attribute("id"));
        let first = one_of(ids.take(MOST_LISTED));
        let rest = match roads.len().saturating_sub(MOST_LISTED) {
            0 => String::new(),
            rest => format!(" (and {rest} more)"),
        };
        let (reason, wanted) = match id {
            Some(id) => (format!("there is no road `{id}` in this file"), first + &rest),
            None => (
                format!("this file has {} roads and no position names the ego's", roads.len()),
                format!("a lane or road position of the ego with the `roadId` {first}{rest}"),
            ),
        };
        return Err(reader.meaning(root, reason, wanted));
    };
    reader.road(road)
}

struct Reader<'a> {
    file: &'a str,
}

impl Reader<'_> {
    fn road(&self, road: &Element) -> Result<Road, ReadError> {
        let length_m = self.number(road, "length")?;
        let straight = self.line(road, length_m)?;
        let steepest_slope = self.steepest_slope(road, length_m)?;
        let lanes = road.child("lanes");
        let Some(lanes) = lanes else {
            return Err(self.element(road, "OpenDRIVE", "has no lanes", "`lanes`"));
        };
        let mut sections = lanes.children.iter().filter(|child| child.name == "laneSection");
        let Some(section) = sections.next() else {
            return Err(self.element(lanes, "road", "has no lane section", "one `laneSection`"));
        };
        if let Some(second) = sections.next() {
            return Err(self.element(second, "lanes", "is there twice", "one lane section"));
        }
        let mut offset_m = 0.0;
        for offset in lanes.children.iter().filter(|child| child.name == "laneOffset") {
            offset_m = self.constant(offset)?;
            if self.number(offset, "s")? != 0.0 {
                return Err(self.element(
                    offset,
                    "lanes",
                    "changes along the road",
                    "one from s = 0",
                ));
            }
        }
        let mut read = Vec::new();
        for side in ["left", "right"] {
            self.side(section, side, offset_m, &mut read)?;
        }
        if read.is_empty() {
            return Err(self.element(section, "lanes", "has no lanes", "at least one lane"));
        }
        read.sort_by(|a, b| a.center_m.total_cmp(&b.center_m));
        let id = road.attribute("id").unwrap_or_default().to_owned();
        let left_hand = road.attribute("rule") == Some("LHT");
        Ok(Road { id, length_m: Some(length_m), straight, steepest_slope, left_hand, lanes: read })
    }

    /// The lanes of one side, from the reference line outwards.
    fn side(
        &self,
        section: &Element,
        side: &str,
        offset_m: f64,
        read: &mut Vec<Lane>,
    ) -> Result<(), ReadError> {
        let Some(group) = section.child(side) else { return Ok(()) };
        let mut lanes: Vec<(i32, &Element)> = Vec::new();
        for lane in group.children.iter().filter(|child| child.name == "lane") {
            let id = self.number(lane, "id")? as i32;
            if id == 0 || (id > 0) != (side == "left") {
                let expected = "positive ids on the left, negative ones on the right";
                return Err(self.element(lane, side, "has an id of the other side", expected));
            }
            lanes.push((id, lane));
        }
        lanes.sort_by_key(|(id, _)| id.abs());
        let mut edge_m = 0.0;
        for (id, lane) in lanes {
            let mut widths = lane.children.iter().filter(|child| child.name == "width");
            let Some(width) = widths.next() else {
                return Err(self.element(lane, side, "has no width", "one `width`"));
            };
            if let Some(second) = widths.next() {
                return Err(self.element(second, "lane", "is there twice", "one constant width"));
            }
            let width_m = self.constant(width)?;
            let sign = f64::from(id.signum());
            let center_m = offset_m + sign * (edge_m + 0.5 * width_m);
            read.push(Lane { id, center_m, width_m });
            edge_m += width_m;
        }
        Ok(())
    }

    /// The reference line, when it is straight.
    fn line(&self, road: &Element, length_m: f64) -> Result<Option<Line>, ReadError> {
        let view = road.child("planView");
        let pieces: Vec<&Element> = view
            .map(|view| view.children.iter().filter(|child| child.name == "geometry").collect())
            .unwrap_or_default();
        let Some(first) = pieces.first() else {
            return Err(self.element(road, "OpenDRIVE", "has no geometry", "`planView`"));
        };
        if !(length_m > 0.0) {
            return Err(self.meaning(road, "the road has no length".to_owned(), "a length".into()));
        }
        let heading_rad = self.number(first, "hdg")?;
        let mut straight = true;
        for piece in &pieces {
            let heading = self.number(piece, "hdg")?;
            straight &= piece.child("line").is_some() && (heading - heading_rad).abs() < 1e-9;
        }
        let start =
            Line { x_m: self.number(first, "x")?, y_m: self.number(first, "y")?, heading_rad };
        Ok(straight.then_some(start))
    }

    /// The largest slope of the pieces of the elevation, up or down: `b + 2 c x + 3 d x²`.
    fn steepest_slope(&self, road: &Element, length_m: f64) -> Result<f64, ReadError> {
        let Some(profile) = road.child("elevationProfile") else { return Ok(0.0) };
        let pieces: Vec<_> = profile.children.iter().filter(|e| e.name == "elevation").collect();
        let mut steepest: f64 = 0.0;
        for (i, piece) in pieces.iter().enumerate() {
            let start_m = self.number(piece, "s")?;
            let end_m = match pieces.get(i + 1) {
                Some(next) => self.number(next, "s")?,
                None => length_m,
            };
            let [b, c, d] =
                [self.number(piece, "b")?, self.number(piece, "c")?, self.number(piece, "d")?];
            let piece_m = (end_m - start_m).max(0.0);
            // The extremes are at the ends, or at the turning point of a cubic's slope.
            let turn_m = if d == 0.0 { 0.0 } else { (-c / (3.0 * d)).clamp(0.0, piece_m) };
            for x in [0.0, turn_m, piece_m] {
                steepest = steepest.max((b + (2.0 * c + 3.0 * d * x) * x).abs());
            }
        }
        Ok(steepest)
    }

    /// The value of a polynomial that must be constant.
    fn constant(&self, element: &Element) -> Result<f64, ReadError> {
        for factor in ["b", "c", "d"] {
            if self.number(element, factor)? != 0.0 {
                let expected = "a constant (b, c and d are 0)";
                return Err(self.element(element, "lane", "changes along the road", expected));
            }
        }
        self.number(element, "a")
    }

    fn number(&self, element: &Element, attribute: &str) -> Result<f64, ReadError> {
        let text = element.attribute(attribute).unwrap_or_default();
        text.trim().parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(|| {
            ReadError::Attribute {
                place: self.place(element),
                attribute: attribute.to_owned(),
                element: element.name.clone(),
                reason: format!("`{text}` is not a number"),
                expected: "a number".to_owned(),
            }
        })
    }

    fn place(&self, element: &Element) -> Place {
        Place { file: self.file.to_owned(), spot: element.spot }
    }

    fn element(
        &self,
        element: &Element,
        parent: &str,
        fault: &'static str,
        expected: &str,
    ) -> ReadError {
        ReadError::Element {
            place: self.place(element),
            element: element.name.clone(),
            parent: parent.to_owned(),
            fault,
            expected: expected.to_owned(),
        }
    }

    fn meaning(&self, element: &Element, reason: String, expected: String) -> ReadError {
        ReadError::Meaning { place: self.place(element), reason, expected }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xml;

    const STRAIGHT: &str = r#"<OpenDRIVE><road id="7" length="100">
<planView><geometry s="0" x="1" y="2" hdg="0.5" length="100"><line/></geometry></planView>
<lanes><laneOffset s="0" a="0.5" b="0" c="0" d="0"/><laneSection s="0">
<left><lane id="1"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></left>
<center><lane id="0"/></center>
<right><lane id="-1"><width sOffset="0" a="2" b="0" c="0" d="0"/></lane>
<lane id="-2"><width sOffset="0" a="4" b="0" c="0" d="0"/></lane></right>
</laneSection></lanes></road></OpenDRIVE>"#;

    fn road(text: &str) -> Result<Road, ReadError> {
        read(&xml::parse("a.xodr", text).expect("it is well-formed"), None)
    }

    #[test]
    fn lanes_lie_beside_each_other() {
        let road = road(STRAIGHT).expect("it is straight");
        let centers: Vec<(i32, f64)> = road.lanes.iter().map(|l| (l.id, l.center_m)).collect();
        assert_eq!(centers, [(-2, -3.5), (-1, -0.5), (1, 2.0)]);
        assert_eq!(road.straight, Some(Line { x_m: 1.0, y_m: 2.0, heading_rad: 0.5 }));
        assert_eq!(road.length_m, Some(100.0));
        let beside = |t, n| road.lane_beside(t, n).map(|lane| lane.id);
        assert_eq!([beside(-3.0, 1), beside(-3.0, 2), beside(-3.0, 3)], [Some(-1), Some(1), None]);
        assert!(road.holds(3.4) && !road.holds(3.6));
    }

    #[test]
    fn a_curved_road_is_unrolled_and_says_so() {
        let curved = STRAIGHT.replace("<line/>", "<arc curvature=\"0.001\"/>");
        assert_eq!(road(&curved).expect("its lanes are constant").straight, None);
    }

    #[test]
    fn a_road_with_grades_is_read_with_its_steepest_slope() {
        let with = |pieces: &str| {
            let profile = format!("<elevationProfile>{pieces}</elevationProfile>\n<planView");
            road(&STRAIGHT.replacen("<planView", &profile, 1)).expect("grades are read")
        };
        assert_eq!(with("").steepest_slope, 0.0);
        let first = "<elevation s=\"0\" a=\"3\" b=\"0.01\" c=\"0\" d=\"0\"/>";
        assert_eq!(with(first).steepest_slope, 0.01);
        // At its end, 50 m on, the second one falls with 2 * 0.0004 * 50.
        let second = "<elevation s=\"50\" a=\"3.5\" b=\"0\" c=\"-0.0004\" d=\"0\"/>";
        assert!((with(&format!("{first}{second}")).steepest_slope - 0.04).abs() < 1e-12);
        // 3 d x² + 2 c x is largest at x = -c / (3 d) = 25 m: c²/(3 d) = 0.03.
        let hill = "<elevation s=\"0\" a=\"0\" b=\"0\" c=\"0.0012\" d=\"-0.000016\"/>";
        let far = "<elevation s=\"60\" a=\"0\" b=\"0\" c=\"0\" d=\"0\"/>";
        assert!((with(&format!("{hill}{far}")).steepest_slope - 0.03).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_driven_is_refused_with_its_line() {
        for (from, to, expected) in [
            (
                "a=\"4\" b=\"0\"",
                "a=\"4\" b=\"0.1\"",
                "a.xodr:7:15: element `width` in `lane` changes",
            ),
            (
                "<laneOffset",
                "<laneSection s=\"0\"/><laneOffset",
                "a.xodr:3:73: element `laneSection` in `lanes` is there twice",
            ),
            (
                "length=\"100\">\n<plan",
                "length=\"0\">\n<plan",
                "a.xodr:1:12: the road has no length",
            ),
            (
                "<road id",
                "<road id=\"1\"/><road id",
                "a.xodr:1:1: this file has 2 roads and no position names the ego's, expected a lane or road position of \
                 the ego with the `roadId` `1` or `7`",
            ),
            ("OpenDRIVE", "Map", "element `Map`"),
        ] {
            let text = STRAIGHT.replace(from, to);
            let shown = road(&text).expect_err(to).to_string();
            assert!(shown.starts_with(expected) || shown.contains(expected), "{shown}");
        }
    }
}
