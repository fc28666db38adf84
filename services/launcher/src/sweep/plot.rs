//! Pictures: panels over one axis, as SVG.

use plotters::prelude::*;

/// Width of a picture, pixels.
const WIDTH: u32 = 900;
/// Height of a panel, pixels.
const PANEL: u32 = 220;
/// Height of the title, pixels.
const TITLE: u32 = 40;

/// A named curve.
pub struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
}

impl Curve {
    /// A curve.
    pub fn new(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points }
    }
}

/// Draws panels over the named axis, which goes from the first to the second of `ends`.
pub fn chart_over(
    title: &str,
    axis: &str,
    ends: (f64, f64),
    panels: &[(&str, Vec<Curve>)],
) -> String {
    let mut svg = String::new();
    draw(title, axis, ends, panels, &mut svg).expect("drawing into a string does not fail");
    svg
}

fn draw(
    title: &str,
    axis: &str,
    ends: (f64, f64),
    panels: &[(&str, Vec<Curve>)],
    svg: &mut String,
) -> Result<(), Box<dyn std::error::Error>> {
    let height = TITLE + PANEL * u32::try_from(panels.len())?;
    let root = SVGBackend::with_string(svg, (WIDTH, height)).into_drawing_area();
    root.fill(&WHITE)?;
    let area = root.titled(title, ("sans-serif", 22))?;
    for (index, ((label, curves), area)) in
        panels.iter().zip(area.split_evenly((panels.len(), 1))).enumerate()
    {
        let (low, high) = range(curves);
        let mut chart = ChartBuilder::on(&area)
            .margin_right(20)
            .margin_top(8)
            .x_label_area_size(if index + 1 == panels.len() { 36 } else { 20 })
            .y_label_area_size(60)
            .build_cartesian_2d(ends.0..ends.1, low..high)?;
        let mut mesh = chart.configure_mesh();
        mesh.y_desc(*label)
            .y_labels(7)
            .y_label_formatter(&|value| format!("{}", (value * 100.0).round() / 100.0))
            .light_line_style(WHITE)
            .axis_desc_style(("sans-serif", 14));
        if index + 1 == panels.len() {
            mesh.x_desc(axis);
        }
        mesh.draw()?;
        for (place, curve) in curves.iter().enumerate() {
            let style = Palette99::pick(place).stroke_width(2);
            let drawn = chart.draw_series(LineSeries::new(curve.points.iter().copied(), style))?;
            drawn
                .label(curve.name.as_str())
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], style));
        }
        if curves.len() > 1 {
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperRight)
                .background_style(WHITE.mix(0.8))
                .border_style(BLACK.mix(0.3))
                .draw()?;
        }
    }
    root.present()?;
    drop(area);
    Ok(())
}

/// Range of the values with a margin, never empty.
fn range(curves: &[Curve]) -> (f64, f64) {
    // Room for the legend above the curves.
    let legend = if curves.len() > 1 { 0.35 } else { 0.0 };
    let values = || curves.iter().flat_map(|curve| &curve.points).map(|point| point.1);
    let low = values().fold(f64::INFINITY, f64::min);
    let high = values().fold(f64::NEG_INFINITY, f64::max);
    if low > high {
        return (0.0, 1.0);
    }
    let margin = (0.08 * (high - low)).max(0.1);
    (low - margin, high + margin + legend * (high - low))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_has_its_labels_and_survives_empty_and_constant_curves() {
        let constant = Curve::new("flat", vec![(0.0, 3.0), (5.0, 3.0)]);
        let picture = chart_over(
            "A title",
            "time, s",
            (0.0, 5.0),
            &[
                ("speed, km/h", vec![constant, Curve::new("nothing", Vec::new())]),
                ("mode", vec![Curve::new("nothing", Vec::new())]),
            ],
        );
        for text in ["A title", "speed, km/h", "mode", "time, s", "flat"] {
            assert!(picture.contains(text), "{text} is missing");
        }
    }
}
