//! Markers and points as CDR.

use super::ground::Place;
use crate::cdr::Cdr;
use messages::Detection;

/// A colour, red, green and blue from 0 to 255.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Color([u8; 3]);

impl Color {
    pub(super) const BLUE: Self = Self([38, 114, 204]);
    pub(super) const ORANGE: Self = Self([230, 126, 34]);
    pub(super) const GREY: Self = Self([150, 150, 150]);
    pub(super) const RED: Self = Self([214, 48, 49]);
    pub(super) const GREEN: Self = Self([39, 174, 96]);
    pub(super) const YELLOW: Self = Self([241, 196, 15]);
    const WHITE: Self = Self([255, 255, 255]);
}

/// `Marker.type` and `Marker.action` of `visualization_msgs`.
pub(super) mod kind {
    pub(crate) const CUBE: i32 = 1;
    pub(crate) const SPHERE: i32 = 2;
    pub(crate) const LINE_STRIP: i32 = 4;
    pub(crate) const LINE_LIST: i32 = 5;
    pub(crate) const TEXT: i32 = 9;
    pub(crate) const ADD: i32 = 0;
    pub(crate) const DELETE_ALL: i32 = 3;
}

/// A marker in the frame `road`.
#[derive(Debug)]
pub(super) struct Marker {
    namespace: &'static str,
    kind: i32,
    action: i32,
    position_m: [f64; 3],
    heading_rad: f64,
    scale_m: [f64; 3],
    color: Color,
    points_m: Vec<[f64; 3]>,
    text: String,
}

impl Marker {
    /// Removes all that were drawn before.
    pub(super) fn clear() -> Self {
        let color = Color::WHITE;
        Self { action: kind::DELETE_ALL, ..Self::new("", kind::CUBE, [0.0; 3], [0.0; 3], color) }
    }

    /// This marker turned about the vertical axis.
    pub(super) fn turned(self, heading_rad: f64) -> Self {
        Self { heading_rad, ..self }
    }

    /// Lines between the points of each pair, or a line through them all.
    pub(super) fn lines(
        namespace: &'static str,
        kind: i32,
        width_m: f64,
        points_m: Vec<[f64; 3]>,
        color: Color,
    ) -> Self {
        let scale_m = [width_m, 0.0, 0.0];
        Self { points_m, ..Self::new(namespace, kind, [0.0; 3], scale_m, color) }
    }

    pub(super) fn text(middle_m: [f64; 3], text: String) -> Self {
        Self { text, ..Self::new("text", kind::TEXT, middle_m, [0.0, 0.0, 1.0], Color::WHITE) }
    }

    pub(super) fn new(
        namespace: &'static str,
        kind: i32,
        position_m: [f64; 3],
        scale_m: [f64; 3],
        color: Color,
    ) -> Self {
        let action = kind::ADD;
        let (points_m, text, heading_rad) = (Vec::new(), String::new(), 0.0);
        Self { namespace, kind, action, position_m, heading_rad, scale_m, color, points_m, text }
    }
}

/// `visualization_msgs/msg/MarkerArray`.
pub(super) fn markers(unix_ns: i64, markers: &[Marker]) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.count(markers.len());
    for (id, marker) in (0..).zip(markers) {
        cdr.header(unix_ns, "road").text(marker.namespace);
        cdr.i32(id).i32(marker.kind).i32(marker.action);
        cdr.point(marker.position_m).turned(marker.heading_rad).point(marker.scale_m);
        for share in marker.color.0 {
            cdr.f32(f32::from(share) / 255.0);
        }
        // Opaque, for ever, not locked to its frame.
        cdr.f32(1.0).i32(0).u32(0).u8(0);
        cdr.count(marker.points_m.len());
        for point in &marker.points_m {
            cdr.point(*point);
        }
        // No colours of points, no texture, no coordinates in it.
        cdr.count(0).text("").header(0, "").text("").count(0).count(0);
        // No mesh.
        cdr.text(&marker.text).text("").text("").count(0).u8(0);
    }
    cdr.finish()
}

/// Step between the points of an outline, m.
const FINE_M: f64 = 0.5;

#[derive(Debug, Default)]
pub(super) struct Points(Vec<([f64; 2], Color)>);

impl Points {
    /// The outline of a rectangle of `[length, width]` whose back is at a place, in the middle of its width.
    pub(super) fn rectangle(&mut self, rear: &Place, [length, width]: [f64; 2], color: Color) {
        for side in [-0.5, 0.5] {
            self.row(rear, [0.0, side * width], [length, 0.0], FINE_M, color);
        }
        for end in [0.0, length] {
            self.row(rear, [end, -0.5 * width], [0.0, width], FINE_M, color);
        }
    }

    pub(super) fn all(&mut self, points: Vec<[f64; 2]>, color: Color) {
        self.0.extend(points.into_iter().map(|point| (point, color)));
    }

    /// A line across the road at a place.
    pub(super) fn across(&mut self, place: &Place, width: f64, color: Color) {
        self.row(place, [0.0, -0.5 * width], [0.0, width], 0.5 * FINE_M, color);
    }

    /// Points from one ahead of a place and to its left on.
    fn row(
        &mut self,
        place: &Place,
        [x, y]: [f64; 2],
        [dx, dy]: [f64; 2],
        step: f64,
        color: Color,
    ) {
        let count = (dx.abs().max(dy.abs()) / step).round().clamp(1.0, 1000.0);
        for k in 0..=count as u32 {
            let share = f64::from(k) / count;
            self.0.push((place.point(x + share * dx, y + share * dy), color));
        }
    }

    /// `sensor_msgs/msg/PointCloud2` with the fields x, y, z and rgb.
    pub(super) fn cloud(&self, unix_ns: i64, frame: &str) -> Vec<u8> {
        let points = self.0.iter().map(|([x, y], Color([r, g, b]))| {
            // As every viewer expects it: blue, green, red, nothing, taken for a float.
            let color = f32::from_le_bytes([*b, *g, *r, 0]);
            [*x as f32, *y as f32, 0.0, color]
        });
        cloud(unix_ns, frame, ["x", "y", "z", "rgb"], points)
    }
}

/// Detections as a cloud in the ego's frame, with range rate, signal-to-noise ratio and cross section.
pub(super) fn detections(unix_ns: i64, detections: &[Detection]) -> Vec<u8> {
    let fields = ["x", "y", "z", "range_rate_mps", "snr_db", "rcs_dbsm"];
    let points = detections.iter().map(|detection| {
        let (sin, cos) = libm::sincos(detection.azimuth_rad);
        let [x, y] = [cos, sin].map(|share| (share * detection.range_m) as f32);
        let quantities = [detection.range_rate_mps, detection.snr_db, detection.rcs_dbsm];
        let [rate, snr, rcs] = quantities.map(|quantity| quantity as f32);
        [x, y, 0.5, rate, snr, rcs]
    });
    cloud(unix_ns, "ego", fields, points)
}

/// `PointField.FLOAT32`.
const FLOAT32: u8 = 7;

fn cloud<const N: usize>(
    unix_ns: i64,
    frame: &str,
    fields: [&str; N],
    points: impl ExactSizeIterator<Item = [f32; N]>,
) -> Vec<u8> {
    let mut cdr = Cdr::new();
    let step = 4 * N;
    let bytes = step * points.len();
    cdr.header(unix_ns, frame).u32(1).count(points.len()).count(N);
    for (index, field) in fields.iter().enumerate() {
        cdr.text(field).count(4 * index).u8(FLOAT32).u32(1);
    }
    cdr.u8(0).count(step).count(bytes).count(bytes);
    for value in points.flatten() {
        cdr.raw(&value.to_le_bytes());
    }
    cdr.u8(1);
    cdr.finish()
}
