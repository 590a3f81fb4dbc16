//! Time against distance as a picture.

use std::fmt::Display;

use anyhow::{Result, anyhow};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const SIZE: (u32, u32) = (860, 460);
// Colours of ours and others', distinct also for the colour-blind (after Okabe and Ito).
const COLOURS: [RGBColor; 2] = [RGBColor(0, 114, 178), RGBColor(120, 120, 120)];

// From this fraction of the picture's width on, a name is placed left of its point.
const LEFT_FROM: f64 = 0.7;

pub struct CurvePoint {
    pub name: String,
    pub is_ours: bool,
    pub place: (f64, f64),
}

pub fn draw_curve(points: &[CurvePoint]) -> Result<String> {
    let mut picture = String::new();
    {
        let root = SVGBackend::with_string(&mut picture, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(drawing_error)?;
        let places = || points.iter().map(|point| point.place);
        let [x, y] = [axis_range(places().map(|place| place.0), 1.1), axis_range(places().map(|place| place.1), 1.1)];
        let mut builder = ChartBuilder::on(&root);
        builder.margin(16).x_label_area_size(44).y_label_area_size(60);
        let mut axes = builder.build_cartesian_2d((x.0..x.1).log_scale(), y.0..y.1).map_err(drawing_error)?;
        let mut mesh = axes.configure_mesh();
        mesh.x_desc("time, of the processor").y_desc("mean distance").light_line_style(TRANSPARENT);
        mesh.x_label_formatter(&|x| format!("{x:.3}").trim_end_matches('0').trim_end_matches('.').to_owned());
        mesh.y_label_formatter(&|y| format!("{y:.1}")).bold_line_style(BLACK.mix(0.1)).draw().map_err(drawing_error)?;
        let far_right = x.0 * (x.1 / x.0).powf(LEFT_FROM);
        let element = |CurvePoint { name, is_ours, place }: &CurvePoint| {
            let colour = COLOURS[usize::from(!is_ours)];
            let (side, shift) = if place.0 > far_right { (HPos::Right, -9) } else { (HPos::Left, 9) };
            let style = ("sans-serif", 13).into_font().color(&colour).pos(Pos::new(side, VPos::Center));
            let circle = Circle::new((0, 0), 5, colour.filled());
            EmptyElement::at(*place) + circle + Text::new(name.clone(), (shift, 0), style)
        };
        axes.draw_series(points.iter().map(element)).map_err(drawing_error)?;
        root.present().map_err(drawing_error)?;
    }
    Ok(picture)
}

// Range of positive values on an axis; `margin` is the factor above the largest.
fn axis_range(values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, 0.0), |(low, high), value| (value.min(low), value.max(high)));
    (low / 1.3, high * margin)
}

fn drawing_error(error: impl Display) -> anyhow::Error {
    anyhow!("the curve cannot be drawn: {error}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_has_its_point_and_its_name() {
        let point = |name: &str, place| CurvePoint { name: name.into(), is_ours: true, place };
        let picture = draw_curve(&[point("one", (1.0, 1.0)), point("other", (20.0, 0.4))]).unwrap();
        assert_eq!(picture.matches("<circle").count(), 2);
        assert!(picture.contains("one") && picture.contains("other") && picture.contains("mean distance"));
    }
}
