//! What stands above a plot: its title, and the legend, where it hides nothing.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::canvas::{Area, Drawn, FINE, font, line, width_of};

/// Height of the title and a legend of one row.
const HEIGHT: i32 = 72;
const ROW: i32 = 20;
const SIZE: f64 = 13.0;
/// What an entry takes beside its text.
const SIGN: f64 = 64.0;
/// The most letters of an entry.
const MOST_LETTERS: usize = 40;

/// What an entry of a legend stands for.
#[derive(Clone, Copy)]
pub(super) enum Sign {
    /// Dots of a colour.
    Dot(RGBColor),
    /// A line of a colour.
    Line(RGBColor),
}

/// The title of a plot and its legend.
pub(super) struct Header<'a> {
    title: &'a str,
    entries: Vec<(Sign, String)>,
    /// Width of the whole plot.
    width: i32,
    columns: usize,
    /// Width of a column.
    column: f64,
}

impl<'a> Header<'a> {
    /// The header of a plot of a width.
    pub(super) fn new(title: &'a str, entries: &[(Sign, &str)], width: i32) -> Self {
        let entries: Vec<(Sign, String)> =
            entries.iter().map(|(sign, name)| (*sign, shortened(name))).collect();
        let widths = entries.iter().map(|(_, name)| width_of(name, SIZE) + SIGN);
        let column = widths.fold(1.0, f64::max);
        let room = (f64::from(width - 40) / column).floor().clamp(1.0, 4.0) as usize;
        let columns = room.min(entries.len()).max(1);
        Self { title, entries, width, columns, column }
    }

    /// How high it is.
    pub(super) fn height(&self) -> i32 {
        HEIGHT + ROW * (self.entries.len().div_ceil(self.columns) as i32 - 1).max(0)
    }

    /// Draws it at the top of `area`.
    pub(super) fn draw(&self, area: &Area<'_>) -> Drawn {
        let letters = self.title.chars().count().max(1) as f64;
        let size = (f64::from(self.width - 40) / (0.55 * letters)).clamp(8.0, 19.0);
        let centred = Pos::new(HPos::Center, VPos::Center);
        let middle = self.width / 2;
        area.draw_text(self.title, &font(size).pos(centred), (middle * FINE, 24 * FINE))?;
        let left = 0.5 * (f64::from(self.width) - self.columns as f64 * self.column);
        let style = font(SIZE).pos(Pos::new(HPos::Left, VPos::Center));
        for (index, (sign, name)) in self.entries.iter().enumerate() {
            let x = left + (index % self.columns) as f64 * self.column;
            let y = (54 + ROW * (index / self.columns) as i32) * FINE;
            let at = |along: f64| (((x + along) * f64::from(FINE)) as i32, y);
            match *sign {
                Sign::Dot(color) => area.draw(&Circle::new(at(30.0), 4 * FINE, color.filled()))?,
                Sign::Line(color) => {
                    area.draw(&PathElement::new([at(10.0), at(38.0)], line(color, 2.0)))?;
                }
            }
            area.draw_text(name, &style, at(44.0))?;
        }
        Ok(())
    }
}

/// A name that leaves room for others.
fn shortened(name: &str) -> String {
    if name.chars().count() <= MOST_LETTERS {
        return name.to_owned();
    }
    name.chars().take(MOST_LETTERS - 1).chain(['…']).collect()
}
