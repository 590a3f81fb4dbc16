//! Charts of an evaluation with logarithmic axes.

use std::fmt::Display;

use crate::axis_range::axis_range;
use crate::evaluate::{Chart, MethodLine};
use plotters::prelude::*;

use neural_mesh_cli::shared::Failure;

const SIZE: (u32, u32) = (1000, 620);

// Colours are distinct also for the colour-blind (after Okabe and Ito).
const COLOURS: [RGBColor; 11] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(153, 79, 0),
    RGBColor(120, 94, 240),
    RGBColor(128, 128, 128),
    RGBColor(170, 0, 50),
];

pub fn colour(at: usize) -> String {
    let RGBColor(red, green, blue) = COLOURS[at % COLOURS.len()];
    format!("#{red:02x}{green:02x}{blue:02x}")
}

pub fn draw_chart(chart: &Chart) -> Result<String, Failure> {
    let mut picture = String::new();
    {
        let root = SVGBackend::with_string(&mut picture, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(drawing_failure)?;
        let mut builder = ChartBuilder::on(&root);
        builder.margin(16).x_label_area_size(44).y_label_area_size(76).caption(chart.title, ("sans-serif", 17));
        let points = || chart.lines.iter().flat_map(|line| &line.points);
        let [x, y] = [axis_range(points().map(|point| point.0), 1.3), axis_range(points().map(|point| point.1), 1.3)];
        let axes = builder.build_cartesian_2d((x.0..x.1).log_scale(), (y.0..y.1).log_scale());
        let mut axes = axes.map_err(drawing_failure)?;
        let mut mesh = axes.configure_mesh();
        mesh.x_desc(chart.x).y_desc(chart.y).light_line_style(TRANSPARENT).bold_line_style(BLACK.mix(0.1));
        mesh.x_label_formatter(&|value| format_short(*value)).y_label_formatter(&|value| format_short(*value));
        mesh.draw().map_err(drawing_failure)?;
        for (at, MethodLine { method, points }) in chart.lines.iter().enumerate() {
            let style = ShapeStyle { color: COLOURS[at % COLOURS.len()].to_rgba(), filled: true, stroke_width: 2 };
            let line = LineSeries::new(points.iter().copied(), style).point_size(3);
            let series = axes.draw_series(line).map_err(drawing_failure)?;
            series.label(method.as_str()).legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
        }
        let mut legend = axes.configure_series_labels();
        legend.position(emptiest_corner(chart, x, y));
        legend.background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.3)).draw().map_err(drawing_failure)?;
        root.present().map_err(drawing_failure)?;
    }
    Ok(picture)
}

fn drawing_failure(error: impl Display) -> Failure {
    Failure::Failed(format!("cannot be drawn: {error}: check the rows"))
}

fn emptiest_corner(chart: &Chart, x: (f64, f64), y: (f64, f64)) -> SeriesLabelPosition {
    let middle = |(low, high): (f64, f64)| (low * high).sqrt();
    let points = || chart.lines.iter().flat_map(|line| &line.points);
    let n_points = |right: bool, upper: bool| {
        points().filter(|(a, b)| (*a > middle(x)) == right && (*b > middle(y)) == upper).count()
    };
    let corners = [
        (n_points(true, true), SeriesLabelPosition::UpperRight),
        (n_points(false, true), SeriesLabelPosition::UpperLeft),
        (n_points(false, false), SeriesLabelPosition::LowerLeft),
        (n_points(true, false), SeriesLabelPosition::LowerRight),
    ];
    let emptiest = corners.into_iter().min_by_key(|(n_points, _)| *n_points);
    emptiest.map_or(SeriesLabelPosition::UpperRight, |(_, corner)| corner)
}

fn format_short(value: f64) -> String {
    if (1e-3..1e4).contains(&value) { format!("{}", (1e6 * value).round() / 1e6) } else { format!("{value:.0e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_has_its_line() {
        let line = |method: &str, points| MethodLine { method: method.into(), points };
        let lines = vec![line("one", vec![(0.1, 2.0), (0.2, 1.0)]), line("other", vec![(0.1, 1e-9)])];
        let chart = Chart { name: "a", title: "a title", x: "across", y: "up", lines };
        let picture = draw_chart(&chart).unwrap();
        for words in ["<svg", "one", "other", "a title", "across", "up"] {
            assert!(picture.contains(words), "{words}");
        }
        assert_eq!(picture.matches("<circle").count(), 3);
    }

    #[test]
    fn labels_are_short() {
        assert_eq!([0.05, 1000.0, 1e-5, 25000.0].map(format_short), ["0.05", "1000", "1e-5", "2e4"]);
    }
}
