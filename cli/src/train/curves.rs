//! Loss curves of a training as SVG.

use std::fmt::Display;
use std::ops::Range;

use plotters::coord::ranged1d::ValueFormatter;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

const SIZE: (u32, u32) = (1000, 620);

type Chart<'a, 'b, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, Y>>;

struct Curve {
    name: String,
    is_validation: bool,
    points: Vec<(f64, f64)>,
}

/// Draws the table of epochs (CSV) as SVG: training thin, validation thick, totals black.
///
/// # Errors
/// A description of the problem with the table.
pub fn draw_curves(table: &str) -> Result<String, String> {
    let mut curves = read_curves(table)?;
    let mut picture = String::new();
    {
        let root = SVGBackend::with_string(&mut picture, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(drawing_problem)?;
        let mut builder = ChartBuilder::on(&root);
        builder.margin(16).x_label_area_size(40).y_label_area_size(70);
        if is_logarithmic(&curves) {
            // Zeros have no logarithm and are left out.
            curves.iter_mut().for_each(|curve| curve.points.retain(|(_, value)| *value > 0.0));
            let (epochs, (low, high)) = (epochs(&curves), bounds(&curves));
            let values = (low / 1.3..high * 1.3).log_scale();
            draw_chart(builder.build_cartesian_2d(epochs, values).map_err(drawing_problem)?, &curves)?;
        } else {
            let (epochs, (low, high)) = (epochs(&curves), bounds(&curves));
            let margin = if high > low { 0.05 * (high - low) } else { 0.05 * high.abs() + f64::MIN_POSITIVE.sqrt() };
            draw_chart(
                builder.build_cartesian_2d(epochs, low - margin..high + margin).map_err(drawing_problem)?,
                &curves,
            )?;
        }
        root.present().map_err(drawing_problem)?;
    }
    Ok(picture)
}

fn drawing_problem(error: impl Display) -> String {
    format!("cannot be drawn: {error}: check its numbers")
}

fn draw_chart<'a, 'b: 'a, Y>(mut chart: Chart<'a, 'b, Y>, curves: &[Curve]) -> Result<(), String>
where
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut mesh = chart.configure_mesh();
    mesh.x_desc("epoch").y_desc("loss").y_label_formatter(&|value| format!("{value:.1e}"));
    mesh.x_label_formatter(&|epoch| if epoch.fract() == 0.0 { format!("{epoch:.0}") } else { String::new() });
    mesh.light_line_style(BLACK.mix(0.06)).draw().map_err(drawing_problem)?;
    let names = names(curves);
    for curve in curves {
        let width = if curve.is_validation { 3 } else { 1 };
        let style = ShapeStyle { color: colour(&curve.name, &names), filled: true, stroke_width: width };
        let line = LineSeries::new(curve.points.iter().copied(), style).point_size(width);
        let label = format!("{}, {}", curve.name, if curve.is_validation { "validation" } else { "training" });
        let series = chart.draw_series(line).map_err(drawing_problem)?;
        series.label(label).legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
    }
    let mut legend = chart.configure_series_labels();
    legend.background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.3)).draw().map_err(drawing_problem)
}

/// Returns whether a logarithmic scale fits: no value is negative, and one is positive.
fn is_logarithmic(curves: &[Curve]) -> bool {
    let (low, high) = bounds(curves);
    low >= 0.0 && high > 0.0
}

fn read_curves(table: &str) -> Result<Vec<Curve>, String> {
    let mut rows = table.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let columns = rows.next().unwrap_or_default();
    let rows: Vec<Vec<&str>> = rows.filter(|row| row.len() == columns.len()).collect();
    let number = |row: &Vec<&str>, at: usize| row.get(at).and_then(|field| field.parse::<f64>().ok());
    let mut curves = Vec::new();
    for (at, column) in columns.iter().enumerate() {
        let (name, is_validation) = match (column.strip_prefix("train_"), column.strip_prefix("validation_")) {
            (Some(name), _) => (name, false),
            (None, Some(name)) => (name, true),
            (None, None) => continue,
        };
        let points = rows.iter().filter_map(|row| Some((number(row, 0)?, number(row, at)?)));
        let points: Vec<(f64, f64)> = points.filter(|(_, value)| value.is_finite()).collect();
        if !points.is_empty() {
            curves.push(Curve { name: name.into(), is_validation, points });
        }
    }
    if curves.is_empty() {
        Err("contains no losses yet: wait for the end of the first epoch".into())
    } else {
        Ok(curves)
    }
}

fn epochs(curves: &[Curve]) -> Range<f64> {
    1.0..curves.iter().flat_map(|curve| &curve.points).map(|(epoch, _)| *epoch).fold(2.0, f64::max)
}

fn bounds(curves: &[Curve]) -> (f64, f64) {
    let values = || curves.iter().flat_map(|curve| &curve.points).map(|(_, value)| *value);
    (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
}

fn names(curves: &[Curve]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for curve in curves {
        if curve.name != "total" && !names.contains(&curve.name) {
            names.push(curve.name.clone());
        }
    }
    names
}

fn colour(name: &str, names: &[String]) -> RGBAColor {
    match names.iter().position(|other| other == name) {
        Some(at) => Palette99::pick(at).to_rgba(),
        None => BLACK.to_rgba(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_term_has_its_curves() {
        let table = "epoch,learning_rate,steps,train_a,train_total,validation_a,validation_total\n\
            1,0.1,5,0.5,0.5,0.75,0.75\n2,0.09,5,0.25,0.25,0.5,0.5\n";
        let picture = draw_curves(table).unwrap();
        for words in ["<svg", "a, training", "a, validation", "total, training", "total, validation", "epoch"] {
            assert!(picture.contains(words), "{words}");
        }
    }

    #[test]
    fn tables_without_losses_are_refused_and_odd_ones_drawn() {
        for table in ["", "epoch,train_a\n", "epoch,train_a\n1,nan\n", "words\n"] {
            assert!(draw_curves(table).is_err(), "{table}");
        }
        for table in ["epoch,train_a,validation_a\n1,0.5,\n", "epoch,train_a\n1,0\n", "epoch,train_a\n1,1e300\n"] {
            assert!(draw_curves(table).is_ok(), "{table}");
        }
    }

    fn heights(picture: &str) -> Vec<f64> {
        let circles = picture.split("<circle").skip(1);
        circles.filter_map(|rest| rest.split("cy=\"").nth(1)?.split('"').next()?.parse().ok()).collect()
    }

    #[test]
    fn losses_below_zero_are_drawn_on_a_linear_scale() {
        let below = heights(&draw_curves("epoch,train_a\n1,-1\n2,-2\n3,-3\n").unwrap());
        assert_eq!(below.len(), 3, "{below:?}");
        assert!(((below[1] - below[0]) - (below[2] - below[1])).abs() <= 1.0, "{below:?}");
        let above = heights(&draw_curves("epoch,train_a\n1,1\n2,0.1\n3,0.01\n4,0\n").unwrap());
        assert_eq!(above.len(), 3, "the logarithm of 0 is left out: {above:?}");
        assert!(((above[1] - above[0]) - (above[2] - above[1])).abs() <= 1.0, "{above:?}");
    }
}
