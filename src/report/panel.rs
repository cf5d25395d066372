//! A panel with two linear axes, and what is drawn in it.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::axis::Axis;
use super::canvas::{Area, Drawn, FINE, Failure, GRID, INK, font, line};

/// Points beyond this number are thinned out: each bucket keeps its two extremes.
const MOST_POINTS: usize = 2000;

pub(super) const NUMERICAL: RGBColor = RGBColor(0x1f, 0x6f, 0xb4);
pub(super) const EXACT: RGBColor = RGBColor(0xd9, 0x5f, 0x02);

type Chart<'c, 'b> = ChartContext<'c, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// A panel of a plot with its axes.
pub(super) struct Panel<'a> {
    pub(super) x: Axis,
    /// `None` where the panel below carries the labels of the shared axis.
    pub(super) x_label: Option<&'a str>,
    pub(super) y: Axis,
    pub(super) y_label: &'a str,
    pub(super) caption: Option<String>,
}

/// What is drawn over what came before it.
pub(super) enum Layer<'a> {
    /// A dot at every point.
    Dots(&'a [(f64, f64)], RGBColor),
    /// A line of a width through the points, with a gap where one is not finite or outside of the axes.
    Line(&'a [(f64, f64)], RGBColor, f64),
}

impl Panel<'_> {
    /// Draws the panel and its layers.
    pub(super) fn draw(&self, area: &Area<'_>, layers: &[Layer<'_>]) -> Drawn {
        let (x, y) = (&self.x, &self.y);
        let mut chart = self.frame(area)?;
        let scaled = |p: &(f64, f64)| (x.scaled(p.0), y.scaled(p.1));
        // Neither range contains what is not finite.
        let drawable = |p: &(f64, f64)| {
            let (along, up) = scaled(p);
            x.range().contains(&along) && y.range().contains(&up)
        };
        for layer in layers {
            match *layer {
                Layer::Dots(points, color) => {
                    let radius = if points.len() > 250 { 1.5 } else { 3.0 } * f64::from(FINE);
                    let dots = points.iter().filter(|p| drawable(p)).map(scaled);
                    let dot = |p| Circle::new(p, radius as i32, color.filled());
                    chart.draw_series(dots.map(dot))?;
                }
                Layer::Line(points, color, width) => {
                    for run in points.split(|p| !drawable(p)) {
                        let run = run.iter().map(scaled);
                        chart.draw_series(LineSeries::new(run, line(color, width)))?;
                    }
                }
            }
        }
        Ok(())
    }

    /// The empty panel: axes, grid, labels and caption.
    fn frame<'b, 'c>(&self, area: &'c Area<'b>) -> Result<Chart<'c, 'b>, Failure> {
        let (x, y) = (&self.x, &self.y);
        let mut builder = ChartBuilder::on(area);
        builder
            .margin_left(10 * FINE)
            .margin_right(28 * FINE)
            .margin_bottom(8 * FINE)
            .margin_top(8 * FINE)
            .set_label_area_size(LabelAreaPosition::Left, 100 * FINE)
            .set_label_area_size(LabelAreaPosition::Bottom, self.bottom() * FINE);
        if let Some(caption) = &self.caption {
            builder.caption(caption, font(13.0));
        }
        let mut chart = builder.build_cartesian_2d(x.range(), y.range())?;
        let (x_text, y_text) = (|v: &f64| x.tick(*v), |v: &f64| y.tick(*v));
        let mut mesh = chart.configure_mesh();
        mesh.max_light_lines(0)
            .bold_line_style(line(GRID, 1.0))
            .axis_style(line(INK, 1.0))
            .label_style(font(12.5))
            .axis_desc_style(font(14.0))
            .x_labels(x.labels)
            .y_labels(y.labels)
            .set_all_tick_mark_size(5 * FINE)
            .y_label_formatter(&y_text)
            .y_desc(y.named(self.y_label));
        match self.x_label {
            Some(label) => mesh.x_label_formatter(&x_text).x_desc(x.named(label)),
            None => mesh.x_label_formatter(&|_| String::new()),
        };
        mesh.draw()?;
        drop(mesh);
        Ok(chart)
    }

    fn bottom(&self) -> i32 {
        if self.x_label.is_some() { 48 } else { 8 }
    }
}

/// Indices that draw `values` well: all, or the least and the greatest of each bucket.
pub(super) fn thin(values: &[f64]) -> Vec<usize> {
    if values.len() <= MOST_POINTS {
        return (0..values.len()).collect();
    }
    let bucket = values.len().div_ceil(MOST_POINTS / 2);
    let mut kept = Vec::with_capacity(MOST_POINTS);
    for start in (0..values.len()).step_by(bucket) {
        let indices = || start..(start + bucket).min(values.len());
        let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let mut ends: Vec<usize> = [indices().min_by(by_value), indices().max_by(by_value)]
            .into_iter()
            .flatten()
            .collect();
        ends.sort_unstable();
        ends.dedup();
        kept.extend(ends);
    }
    kept
}
