//! The curves of a training as a picture: each loss term and their total over the epochs, on a logarithmic scale.

use std::ops::Range;

use plotters::prelude::*;

/// Width and height in pixels.
const SIZE: (u32, u32) = (1000, 620);

/// One curve: the values of a column that lie above 0, by epoch.
struct Curve {
    name: String,
    is_validation: bool,
    points: Vec<(f64, f64)>,
}

/// Draws the table of epochs (CSV) as SVG: training thin, validation thick, totals black. The error says what is
/// wrong with the table.
pub fn draw(table: &str) -> Result<String, String> {
    let curves = curves(table)?;
    let mut picture = String::new();
    let problem = |error: &dyn std::fmt::Display| format!("cannot be drawn: {error}: check its numbers");
    {
        let root = SVGBackend::with_string(&mut picture, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(|error| problem(&error))?;
        let (epochs, values) = ranges(&curves);
        let mut chart = ChartBuilder::on(&root);
        chart.margin(16).x_label_area_size(40).y_label_area_size(70);
        let mut chart = chart.build_cartesian_2d(epochs, values.log_scale()).map_err(|error| problem(&error))?;
        let mut mesh = chart.configure_mesh();
        mesh.x_desc("epoch").y_desc("loss").y_label_formatter(&|value| format!("{value:.1e}"));
        mesh.x_label_formatter(&|epoch| if epoch.fract() == 0.0 { format!("{epoch:.0}") } else { String::new() });
        mesh.light_line_style(BLACK.mix(0.06));
        mesh.draw().map_err(|error| problem(&error))?;
        let names = names(&curves);
        for curve in &curves {
            let colour = colour(&curve.name, &names);
            let width = if curve.is_validation { 3 } else { 1 };
            let style = ShapeStyle { color: colour, filled: true, stroke_width: width };
            let line = LineSeries::new(curve.points.iter().copied(), style).point_size(width);
            let label = format!("{}, {}", curve.name, if curve.is_validation { "validation" } else { "training" });
            let series = chart.draw_series(line).map_err(|error| problem(&error))?;
            series.label(label).legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
        }
        let mut legend = chart.configure_series_labels();
        legend.background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.3)).draw().map_err(|error| problem(&error))?;
        root.present().map_err(|error| problem(&error))?;
    }
    Ok(picture)
}

/// The columns that are terms, of training and validation.
fn curves(table: &str) -> Result<Vec<Curve>, String> {
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
        let points: Vec<(f64, f64)> = points.filter(|(_, value)| *value > 0.0 && value.is_finite()).collect();
        if !points.is_empty() {
            curves.push(Curve { name: name.into(), is_validation, points });
        }
    }
    if curves.is_empty() { Err("holds no losses yet: wait for the first epoch".into()) } else { Ok(curves) }
}

/// What the axes reach over.
fn ranges(curves: &[Curve]) -> (Range<f64>, Range<f64>) {
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let last = all().map(|(epoch, _)| *epoch).fold(2.0, f64::max);
    let low = all().map(|(_, value)| *value).fold(f64::INFINITY, f64::min);
    let high = all().map(|(_, value)| *value).fold(0.0, f64::max);
    (1.0..last, low / 1.3..high * 1.3)
}

/// Names of the terms, each once.
fn names(curves: &[Curve]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for curve in curves {
        if curve.name != "total" && !names.contains(&curve.name) {
            names.push(curve.name.clone());
        }
    }
    names
}

/// Black for totals, else the term's own.
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
        let picture = draw(table).unwrap();
        for words in ["<svg", "a, training", "a, validation", "total, training", "total, validation", "epoch"] {
            assert!(picture.contains(words), "{words}");
        }
    }

    #[test]
    fn tables_without_losses_are_refused_and_odd_ones_drawn() {
        for table in ["", "epoch,train_a\n", "epoch,train_a\n1,0\n", "epoch,train_a\n1,nan\n", "words\n"] {
            assert!(draw(table).is_err(), "{table}");
        }
        assert!(draw("epoch,train_a,validation_a\n1,0.5,\n").is_ok());
    }
}
