//! A chart with two logarithmic axes: series of labelled marks, and lines.

mod labels;
mod log_axis;

use plotters::element::{DashedPathElement, PathElement};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::report::canvas::{
    self, Area, Drawn, FINE, Failure, GRID, INK, PAPER, font, line, width_of,
};
use labels::{Frame, place};

pub(super) use log_axis::{LogAxis, is_drawable};

const WIDTH: i32 = 900;
const PLOT: i32 = 430;
const LEFT: i32 = 88;
const RIGHT: i32 = 24;
const TITLE: i32 = 44;
const BOTTOM: i32 = 62;
const LEGEND_ROW: i32 = 21;
const LABEL_SIZE: f64 = 11.5;
const LEGEND_SIZE: f64 = 12.5;

/// Colours of series: told apart on light and on dark backgrounds.
const COLORS: [RGBColor; 8] = [
    RGBColor(0x2b, 0x7b, 0xba),
    RGBColor(0xe0, 0x70, 0x1a),
    RGBColor(0x2a, 0x9d, 0x5c),
    RGBColor(0xc8, 0x43, 0x4f),
    RGBColor(0x8d, 0x62, 0xc0),
    RGBColor(0x9a, 0x74, 0x2b),
    RGBColor(0xd4, 0x5d, 0x9e),
    RGBColor(0x3c, 0x9c, 0xa6),
];

/// The shape of what other programs did.
const OF_OTHERS: usize = 3;

/// A chart.
pub(super) struct Chart {
    pub(super) title: String,
    pub(super) x: LogAxis,
    pub(super) y: LogAxis,
    pub(super) series: Vec<Series>,
    /// A line over all series, with its name in the legend.
    pub(super) front: Option<(String, Vec<(f64, f64)>)>,
    /// Dashed lines from one point to another, with their names in the legend.
    pub(super) laws: Vec<(String, [(f64, f64); 2])>,
}

/// Marks of one colour and shape.
pub(super) struct Series {
    pub(super) name: String,
    pub(super) marks: Vec<Mark>,
    /// Whether a thin line joins them.
    pub(super) joined: bool,
    /// Whether another program made them.
    pub(super) of_others: bool,
}

/// A mark at a point of the chart.
pub(super) struct Mark {
    pub(super) x: f64,
    pub(super) y: f64,
    /// The least and the greatest x, where there are several.
    pub(super) spread: Option<(f64, f64)>,
    pub(super) label: String,
    /// Whether its label comes first where there is little room.
    pub(super) first: bool,
}

/// Which series a mark belongs to, for its looks.
#[derive(Clone, Copy)]
struct Look {
    color: RGBColor,
    shape: usize,
}

impl Chart {
    /// The chart as SVG text.
    pub(super) fn svg(&self) -> Result<String, Failure> {
        let legend = Legend::of(self);
        let top = TITLE + legend.rows * LEGEND_ROW + 8;
        let size = (WIDTH, top + PLOT + BOTTOM);
        let frame = Frame {
            left: f64::from(LEFT),
            right: f64::from(WIDTH - RIGHT),
            top: f64::from(top),
            bottom: f64::from(top + PLOT),
        };
        canvas::svg(size, |area| {
            let centred = font(17.0).pos(Pos::new(HPos::Center, VPos::Center));
            area.draw_text(&self.title, &centred, (WIDTH / 2 * FINE, 24 * FINE))?;
            legend.draw(area, self)?;
            self.axes(area, &frame)?;
            self.lines(area, &frame)?;
            self.marks(area, &frame)?;
            self.labels(area, &frame)
        })
    }

    fn look(&self, index: usize) -> Look {
        let color = COLORS[index % COLORS.len()];
        let shape = match self.series[index].of_others {
            true => OF_OTHERS,
            false => index / COLORS.len() % OF_OTHERS,
        };
        Look { color, shape }
    }

    /// Where a point lies, in shown units.
    fn at(&self, frame: &Frame, x: f64, y: f64) -> (f64, f64) {
        let along = frame.left + self.x.part(x) * (frame.right - frame.left);
        let up = frame.bottom - self.y.part(y) * (frame.bottom - frame.top);
        (along, up)
    }

    fn axes(&self, area: &Area<'_>, frame: &Frame) -> Drawn {
        let below = font(LEGEND_SIZE).pos(Pos::new(HPos::Center, VPos::Top));
        for tick in self.x.ticks() {
            let (x, _) = self.at(frame, tick.value, self.y.low());
            draw_line(area, &[(x, frame.top), (x, frame.bottom)], line(GRID, 1.0))?;
            if tick.labelled {
                area.draw_text(&self.x.text(tick.value), &below, fine((x, frame.bottom + 7.0)))?;
            }
        }
        let beside = font(LEGEND_SIZE).pos(Pos::new(HPos::Right, VPos::Center));
        for tick in self.y.ticks() {
            let (_, y) = self.at(frame, self.x.low(), tick.value);
            draw_line(area, &[(frame.left, y), (frame.right, y)], line(GRID, 1.0))?;
            if tick.labelled {
                area.draw_text(&self.y.text(tick.value), &beside, fine((frame.left - 7.0, y)))?;
            }
        }
        let corners =
            [(frame.left, frame.top), (frame.left, frame.bottom), (frame.right, frame.bottom)];
        draw_line(area, &corners, line(INK, 1.0))?;
        let centred = Pos::new(HPos::Center, VPos::Center);
        let middle = 0.5 * (frame.left + frame.right);
        let name = font(13.5).pos(centred);
        area.draw_text(self.x.name(), &name, fine((middle, frame.bottom + 42.0)))?;
        let turned = ("sans-serif", 13.5 * 1.24 * f64::from(FINE)).into_font();
        let turned = turned.transform(FontTransform::Rotate270).color(&INK).pos(centred);
        let middle = 0.5 * (frame.top + frame.bottom);
        Ok(area.draw_text(self.y.name(), &turned, fine((16.0, middle)))?)
    }

    fn lines(&self, area: &Area<'_>, frame: &Frame) -> Drawn {
        for (index, series) in self.series.iter().enumerate() {
            let color = self.look(index).color;
            let at = |mark: &Mark| self.at(frame, mark.x, mark.y);
            if series.joined {
                let path: Vec<_> = series.marks.iter().map(at).collect();
                draw_line(area, &path, line(color, 1.25))?;
            }
            for mark in &series.marks {
                if let Some((least, greatest)) = mark.spread {
                    let ends = [least, greatest].map(|x| self.at(frame, x, mark.y));
                    draw_line(area, &ends, line(color, 1.0))?;
                }
            }
        }
        if let Some((_, front)) = &self.front {
            let path: Vec<_> = front.iter().map(|&(x, y)| self.at(frame, x, y)).collect();
            draw_line(area, &path, line(INK, 1.0))?;
        }
        for (index, (_, ends)) in self.laws.iter().enumerate() {
            draw_dashes(area, ends.map(|(x, y)| self.at(frame, x, y)), index)?;
        }
        Ok(())
    }

    fn marks(&self, area: &Area<'_>, frame: &Frame) -> Drawn {
        for (index, series) in self.series.iter().enumerate() {
            for mark in &series.marks {
                draw_mark(area, self.at(frame, mark.x, mark.y), self.look(index))?;
            }
        }
        Ok(())
    }

    /// The lines that labels keep off, from point to point.
    fn strokes(&self, frame: &Frame) -> Vec<[(f64, f64); 2]> {
        let marks = self.series.iter().flat_map(|series| &series.marks);
        let spread = |mark: &Mark| {
            let (least, greatest) = mark.spread?;
            Some([least, greatest].map(|x| self.at(frame, x, mark.y)))
        };
        let front = self.front.iter().flat_map(|(_, front)| front.windows(2));
        let front = front.map(|ends| [0, 1].map(|k| self.at(frame, ends[k].0, ends[k].1)));
        let laws = self.laws.iter().map(|(_, ends)| ends.map(|(x, y)| self.at(frame, x, y)));
        marks.filter_map(spread).chain(front).chain(laws).collect()
    }

    fn labels(&self, area: &Area<'_>, frame: &Frame) -> Drawn {
        let all = || self.series.iter().flat_map(|series| &series.marks);
        let marks: Vec<(f64, f64)> = all().map(|mark| self.at(frame, mark.x, mark.y)).collect();
        let texts: Vec<(&str, bool)> = all().map(|mark| (&*mark.label, mark.first)).collect();
        let style = font(LABEL_SIZE).pos(Pos::new(HPos::Left, VPos::Center));
        for (text, at) in place(frame, &marks, &self.strokes(frame), &texts, LABEL_SIZE) {
            area.draw_text(text, &style, fine(at))?;
        }
        Ok(())
    }
}

/// What the colours mean, above the plot.
struct Legend {
    columns: i32,
    rows: i32,
}

impl Legend {
    fn entries(chart: &Chart) -> usize {
        chart.series.len() + usize::from(chart.front.is_some()) + chart.laws.len()
    }

    fn of(chart: &Chart) -> Self {
        let front = chart.front.iter().map(|(name, _)| name);
        let laws = chart.laws.iter().map(|(name, _)| name);
        let names = chart.series.iter().map(|series| &series.name).chain(front).chain(laws);
        let widest = names.map(|name| width_of(name, LEGEND_SIZE)).fold(1.0, f64::max) + 44.0;
        let columns = (f64::from(WIDTH - 40) / widest).floor().clamp(1.0, 4.0) as i32;
        let rows = (Self::entries(chart) as i32 + columns - 1) / columns;
        Self { columns, rows }
    }

    fn draw(&self, area: &Area<'_>, chart: &Chart) -> Drawn {
        let column = (WIDTH - 40) / self.columns;
        let style = font(LEGEND_SIZE).pos(Pos::new(HPos::Left, VPos::Center));
        let place = |entry: usize| {
            let (row, along) = (entry as i32 / self.columns, entry as i32 % self.columns);
            let y = TITLE + row * LEGEND_ROW + LEGEND_ROW / 2;
            (f64::from(34 + along * column), f64::from(y))
        };
        for (index, series) in chart.series.iter().enumerate() {
            let (x, y) = place(index);
            draw_mark(area, (x, y), chart.look(index))?;
            area.draw_text(&series.name, &style, fine((x + 14.0, y)))?;
        }
        if let Some((name, _)) = &chart.front {
            let (x, y) = place(chart.series.len());
            draw_line(area, &[(x - 8.0, y), (x + 8.0, y)], line(INK, 1.0))?;
            area.draw_text(name, &style, fine((x + 14.0, y)))?;
        }
        let before = Self::entries(chart) - chart.laws.len();
        for (index, (name, _)) in chart.laws.iter().enumerate() {
            let (x, y) = place(before + index);
            draw_dashes(area, [(x - 14.0, y), (x + 8.0, y)], index)?;
            area.draw_text(name, &style, fine((x + 14.0, y)))?;
        }
        Ok(())
    }
}

/// A place on the canvas.
fn fine((x, y): (f64, f64)) -> (i32, i32) {
    let on = |shown: f64| (shown * f64::from(FINE)).round() as i32;
    (on(x), on(y))
}

fn draw_line(area: &Area<'_>, path: &[(f64, f64)], style: ShapeStyle) -> Drawn {
    let path: Vec<(i32, i32)> = path.iter().copied().map(fine).collect();
    Ok(area.draw(&PathElement::new(path, style))?)
}

/// A dashed line, with dashes by its index.
fn draw_dashes(area: &Area<'_>, ends: [(f64, f64); 2], index: usize) -> Drawn {
    let dash = [5, 9, 2][index % 3] * FINE;
    let style = line(INK, 1.25);
    Ok(area.draw(&DashedPathElement::new(ends.map(fine), dash, 4 * FINE, style))?)
}

fn draw_mark(area: &Area<'_>, at: (f64, f64), look: Look) -> Drawn {
    let Look { color, shape } = look;
    let (x, y) = fine(at);
    let r = 9 * FINE / 2;
    let filled = match shape {
        0 => {
            area.draw(&Circle::new((x, y), r, color.filled()))?;
            return Ok(area.draw(&Circle::new((x, y), r, line(PAPER, 0.75)))?);
        }
        1 => vec![(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)],
        2 => vec![(x, y - r - r / 4), (x + r, y + r), (x - r, y + r)],
        _ => vec![(x, y - r - r / 2), (x + r + r / 2, y), (x, y + r + r / 2), (x - r - r / 2, y)],
    };
    Ok(area.draw(&Polygon::new(filled, color.filled()))?)
}
