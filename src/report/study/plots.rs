//! The pictures of a study.

use super::chart::{Chart, LogAxis, Mark, Series, is_drawable};
use super::{Measured, Point, StudyReport};
use crate::report::OutputError;
use crate::report::canvas::Failure;
use crate::report::format::{significant, wall_time};
use crate::report::output::write_whole;
use std::io::{self, Write};
use std::path::Path;

/// A picture: the stem of its file, its SVG text and a caption.
pub(super) struct Picture {
    pub(super) name: &'static str,
    pub(super) svg: String,
    pub(super) caption: String,
}

/// What errors are called on axes.
const ERROR: &str = "relative L2 of the error";

impl StudyReport {
    /// The pictures: those for which there is something to draw.
    pub(super) fn pictures(&self) -> Result<Vec<Picture>, Failure> {
        let all = [
            self.over_time(),
            self.over_applications(),
            self.over_spacing(),
            self.over_particles(),
            self.rates(),
        ];
        let drawn = all.into_iter().flatten().map(|(name, chart, caption)| {
            Ok(Picture { name, svg: chart.svg()?, caption: caption.to_owned() })
        });
        drawn.collect()
    }

    /// Writes the pictures into `folder`, as `error_time.svg` and so on.
    ///
    /// # Errors
    /// Where one cannot be drawn or written.
    pub fn write_pictures(&self, folder: &Path) -> Result<(), OutputError> {
        let failed = |error: Failure| OutputError::Write {
            path: folder.join("error_time.svg"),
            source: io::Error::other(error),
        };
        for picture in self.pictures().map_err(failed)? {
            let path = folder.join(picture.name).with_extension("svg");
            write_whole(&path, |out| out.write_all(picture.svg.as_bytes()))?;
        }
        Ok(())
    }

    fn over_time(&self) -> Option<(&'static str, Chart, &'static str)> {
        let mut series = self.series(Point::kind, |point, of| {
            let error = of.error_norm()?;
            let Time { x, spread } = Time::of(of);
            Some(mark(point, of, x, error, spread))
        });
        let mut front: Vec<(f64, f64)> = self
            .measured()
            .filter(|(_, of)| of.pareto)
            .filter_map(|(_, of)| Some((of.total_s.median, of.error_norm()?)))
            .filter(|(x, y)| is_drawable(*x) && is_drawable(*y))
            .collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        series.extend(self.others());
        let chart = chart(
            format!("{}: error against run time", self.case),
            ("set-up and solution, wall time", wall_time, 9),
            (ERROR, error_text, 9),
            series,
            Some(("Pareto front".to_owned(), front)),
        )?;
        let caption = "Medians, with lines from the fastest to the slowest run. Numbers are those of \
                       the table; points on the Pareto front also have their spacing. Diamonds are other \
                       programs.";
        Some(("error_time", chart, caption))
    }

    /// What other programs did, a series a program. Labels are short: the table has all of them.
    fn others(&self) -> Vec<Series> {
        let Some(peers) = &self.peers else { return Vec::new() };
        let mut all: Vec<Series> = Vec::new();
        for peer in &peers.points {
            let label = peer.setting.split(',').next().unwrap_or_default().to_owned();
            let (x, y) = (peer.total_s(), peer.l2_relative);
            let mark = Mark { x, y, spread: None, label, first: true };
            if !is_drawable(x) || !is_drawable(y) {
                continue;
            }
            match all.iter_mut().find(|series| series.name == peer.tool) {
                Some(series) => series.marks.push(mark),
                None => all.push(Series {
                    name: peer.tool.clone(),
                    marks: vec![mark],
                    joined: false,
                    of_others: true,
                }),
            }
        }
        all
    }

    fn over_applications(&self) -> Option<(&'static str, Chart, &'static str)> {
        let series = self.series(Point::kind, |point, of| {
            let applications = of.operator_applications as f64;
            Some(mark(point, of, applications, of.error_norm()?, None))
        });
        let chart = chart(
            format!("{}: error against operator applications", self.case),
            ("operator applications, each to the whole field", count_text, 9),
            (ERROR, error_text, 9),
            series,
            None,
        )?;
        let caption = "What an error costs whatever the machine; an application to more particles \
                       takes longer.";
        Some(("error_applications", chart, caption))
    }

    fn over_spacing(&self) -> Option<(&'static str, Chart, &'static str)> {
        let series = self.refined(|point| point.spacing);
        let chart = chart(
            format!("{}: error against spacing", self.case),
            ("spacing dx, m", |x| significant(x, 3), 10),
            (ERROR, error_text, 9),
            series,
            None,
        )?;
        let caption = "Slopes are those of a least-squares line through all points of a series, and of \
                       the line through its two finest.";
        Some(("error_spacing", chart, caption))
    }

    fn over_particles(&self) -> Option<(&'static str, Chart, &'static str)> {
        let series = self.refined(|point| self.along_an_axis(point.particles));
        let x = || series.iter().flat_map(|series| &series.marks).map(|mark| mark.x);
        let (least, most) = (x().reduce(f64::min)?, x().reduce(f64::max)?);
        let laws: Vec<(String, [(f64, f64); 2])> = (self.reference_laws.iter())
            .map(|law| (law.name(), [least, most].map(|n| (n, law.at(n)))))
            .collect();
        let name = match self.dimension {
            1 => "particles n",
            2 => "particles along an axis, n = √N of all N",
            _ => "particles along an axis, n = ∛N of all N",
        };
        let mut chart = chart(
            format!("{}: error against the number of particles", self.case),
            (name, count_text, 9),
            (ERROR, error_text, 9),
            series,
            None,
        )?;
        let errors = chart.series.iter().flat_map(|series| &series.marks).map(|mark| mark.y);
        let of_laws = laws.iter().flat_map(|(_, ends)| ends).map(|end| end.1);
        chart.y = LogAxis::over(ERROR, error_text, errors.chain(of_laws), 9);
        chart.laws = laws;
        let caption = "Slopes are those against the spacing. A dashed line is an error law known from \
                       elsewhere.";
        Some(("error_particles", chart, caption))
    }

    /// The points that differ in their spacing alone, over what `x` makes of them, joined and with their
    /// slopes.
    fn refined(&self, x: impl Fn(&Point) -> f64) -> Vec<Series> {
        let mut series = self.series(
            |point| point.series("spacing"),
            |point, of| {
                let unlabelled = Mark {
                    label: String::new(),
                    ..mark(point, of, x(point), of.error_norm()?, None)
                };
                Some(unlabelled)
            },
        );
        series.retain(|series| series.marks.len() > 1);
        for series in &mut series {
            series.joined = true;
            series.marks.sort_by(|a, b| a.x.total_cmp(&b.x));
            let is_it =
                |order: &&super::Order| order.varies == "spacing" && order.series == series.name;
            let order = self.orders.iter().find(is_it);
            let slopes = order.and_then(|of| of.all.l2_relative.zip(of.finest.l2_relative));
            if let Some((all, finest)) = slopes {
                series.name += &format!(": slope {all:.2} (finest {finest:.2})");
            }
        }
        series
    }

    fn rates(&self) -> Option<(&'static str, Chart, &'static str)> {
        let mut series = self.series(Point::kind, |point, of| {
            Some(mark(point, of, point.particles as f64, of.updates_per_s, None))
        });
        series.iter_mut().flat_map(|of| &mut of.marks).for_each(|mark| mark.label.clear());
        let chart = chart(
            format!("{}: throughput", self.case),
            ("particles", count_text, 9),
            ("particles × operator applications a second", count_text, 9),
            series,
            None,
        )?;
        Some(("throughput", chart, "Of the solution alone, the middle run."))
    }

    /// The points by what `name` calls them, each as `mark` has it.
    fn series(
        &self,
        name_of: impl Fn(&Point) -> String,
        mark: impl Fn(&Point, &Measured) -> Option<Mark>,
    ) -> Vec<Series> {
        let all = self.names(&name_of).into_iter().map(|name| {
            let of_series = self.measured().filter(|(point, _)| name_of(point) == name);
            let marks = of_series.filter_map(|(point, of)| mark(point, of));
            let marks = marks.filter(|mark| is_drawable(mark.x) && is_drawable(mark.y)).collect();
            Series { name, marks, joined: false, of_others: false }
        });
        all.filter(|series: &Series| !series.marks.is_empty()).collect()
    }
}

/// The time of a point: its median, and its ends where there are several runs.
struct Time {
    x: f64,
    spread: Option<(f64, f64)>,
}

impl Time {
    fn of(of: &Measured) -> Self {
        let time = of.total_s;
        let is_wide = time.greatest > time.least && is_drawable(time.least);
        Self { x: time.median, spread: is_wide.then_some((time.least, time.greatest)) }
    }
}

fn mark(point: &Point, of: &Measured, x: f64, y: f64, spread: Option<(f64, f64)>) -> Mark {
    let label = match of.pareto && point.setting("spacing").is_some() {
        true => format!("{}: dx {}", point.number, significant(point.spacing, 3)),
        false => point.number.to_string(),
    };
    Mark { x, y, spread, label, first: of.pareto }
}

/// A chart of `series`, each axis with its name, its texts and the number of labels it has room for.
/// Nothing where there is nothing to draw.
fn chart(
    title: String,
    x: (&str, fn(f64) -> String, usize),
    y: (&str, fn(f64) -> String, usize),
    series: Vec<Series>,
    front: Option<(String, Vec<(f64, f64)>)>,
) -> Option<Chart> {
    if series.is_empty() {
        return None;
    }
    let marks = || series.iter().flat_map(|series| &series.marks);
    let spreads = marks().filter_map(|mark| mark.spread).flat_map(|(a, b)| [a, b]);
    let along = LogAxis::over(x.0, x.1, marks().map(|mark| mark.x).chain(spreads), x.2);
    let up = LogAxis::over(y.0, y.1, marks().map(|mark| mark.y), y.2);
    Some(Chart { title, x: along, y: up, series, front, laws: Vec::new() })
}

/// An error, as a power of ten where it is one: `10⁻³`, `2·10⁻³`.
fn error_text(value: f64) -> String {
    let power = (value.log10() + 1e-9).floor();
    let multiple = value / 10f64.powf(power);
    let raised: String = format!("{power}").chars().map(superscript).collect();
    if (multiple - 1.0).abs() < 1e-6 {
        return format!("10{raised}");
    }
    format!("{}·10{raised}", significant(multiple, 3))
}

fn count_text(value: f64) -> String {
    if value < 1e4 { significant(value, 3) } else { error_text(value) }
}

fn superscript(c: char) -> char {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    c.to_digit(10).map_or('⁻', |digit| digits[digit as usize])
}
