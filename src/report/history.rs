//! `probes.svg` and `front.svg`: values over time, against the exact solution.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use plotters::style::RGBColor;

use super::axis::Axis;
use super::canvas::{self, Failure};
use super::header::{Header, Sign};
use super::output::{OutputError, write_whole};
use super::panel::{EXACT, Layer, NUMERICAL, Panel};

const WIDTH: i32 = 900;
const HEIGHT: i32 = 430;

/// Readings that a history keeps at most, the last one apart.
const MOST_READINGS: usize = 2000;

/// Dots up to this number are drawn over the exact solution, which they leave to be seen between them.
const FEW_DOTS: usize = 60;

/// Colours of traces; that of exact solutions is none of them.
const COLORS: [RGBColor; HistoryPlot::MOST_TRACES] = [
    NUMERICAL,
    RGBColor(0x2a, 0x9d, 0x5c),
    RGBColor(0x8d, 0x62, 0xc0),
    RGBColor(0xc8, 0x43, 0x4f),
    RGBColor(0x3c, 0x9c, 0xa6),
    RGBColor(0xd4, 0x5d, 0x9e),
    RGBColor(0x9a, 0x8a, 0x2b),
    RGBColor(0x75, 0x75, 0x75),
];

/// A value at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Time, s.
    pub time: f64,
    /// The numerical value.
    pub value: f64,
    /// The exact value, where there is one.
    pub exact: Option<f64>,
}

/// Readings over time, few enough to draw however long the run is: when there are too many, every
/// other one goes, and so does every other one from then on.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    kept: Vec<Reading>,
    /// The last reading, where it is not kept.
    last: Option<Reading>,
    /// One reading of so many is kept.
    every: u64,
    count: u64,
}

impl Default for History {
    fn default() -> Self {
        Self { kept: Vec::new(), last: None, every: 1, count: 0 }
    }
}

impl History {
    /// Adds a reading.
    pub fn push(&mut self, reading: Reading) {
        if self.kept.len() == MOST_READINGS {
            let mut index = 0;
            self.kept.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.every *= 2;
        }
        let is_kept = self.count.is_multiple_of(self.every);
        self.last = (!is_kept).then_some(reading);
        self.kept.extend(is_kept.then_some(reading));
        self.count += 1;
    }

    /// How many readings there were.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The readings that are left, by ascending time; the last one is among them.
    pub fn readings(&self) -> impl Iterator<Item = &Reading> {
        self.kept.iter().chain(&self.last)
    }
}

/// A value over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Its name in the legend.
    pub name: String,
    /// What was read.
    pub history: History,
    /// The exact solution as a curve of times (s) and values.
    pub curve: Vec<(f64, f64)>,
}

/// A plot of values over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HistoryPlot {
    /// The title above the plot.
    pub title: String,
    /// What the values are, and their unit if any.
    pub value_label: String,
    /// Whether the time is drawn by its square root.
    pub by_root: bool,
    /// What is drawn: [`Self::MOST_TRACES`] at most.
    pub traces: Vec<Trace>,
}

impl HistoryPlot {
    /// So many traces are told apart by their colours.
    pub const MOST_TRACES: usize = 8;

    /// The plot as SVG: dots for what was read, joined where there is no exact solution, and a line for
    /// the exact solution. What of that is far beyond all readings is left out.
    pub fn to_svg(&self) -> io::Result<String> {
        self.svg().map_err(io::Error::other)
    }

    /// Writes the plot into `folder` under `name` and returns its path.
    pub fn write(&self, folder: &Path, name: &str) -> Result<PathBuf, OutputError> {
        let path = folder.join(name);
        write_whole(&path, |out| out.write_all(self.to_svg()?.as_bytes()))?;
        Ok(path)
    }

    fn svg(&self) -> Result<String, Failure> {
        let traces = &self.traces[..self.traces.len().min(Self::MOST_TRACES)];
        let along = |time: f64| if self.by_root { time.sqrt() } else { time };
        let on_axis = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
            points.iter().map(|&(time, value)| (along(time), value)).collect()
        };
        let readings = || traces.iter().flat_map(|trace| trace.history.readings());
        let values = readings().map(|reading| reading.value);
        let panel = Panel {
            x: Axis::over(readings().map(|reading| along(reading.time)), 10),
            x_label: Some(if self.by_root { "√t (√s)" } else { "time (s)" }),
            y: Axis::over(values.chain(readings().filter_map(|reading| reading.exact)), 8),
            y_label: &self.value_label,
            caption: None,
        };
        let dots: Vec<Vec<(f64, f64)>> = traces
            .iter()
            .map(|trace| trace.history.readings().map(|of| (along(of.time), of.value)).collect())
            .collect();
        let curves: Vec<Vec<(f64, f64)>> =
            traces.iter().map(|trace| on_axis(&trace.curve)).collect();
        let dense = dots.iter().any(|dots| dots.len() > FEW_DOTS);
        let mut exact: Vec<_> = curves.iter().map(|of| Layer::Line(of, EXACT, 1.5)).collect();
        let mut layers = if dense { Vec::new() } else { std::mem::take(&mut exact) };
        for (index, dots) in dots.iter().enumerate() {
            layers.push(Layer::Dots(dots, COLORS[index]));
            if curves[index].is_empty() {
                layers.push(Layer::Line(dots, COLORS[index], 1.0));
            }
        }
        layers.extend(exact);
        let mut entries: Vec<(Sign, &str)> = traces
            .iter()
            .zip(COLORS)
            .map(|(trace, color)| (Sign::Dot(color), &*trace.name))
            .collect();
        if curves.iter().any(|curve| !curve.is_empty()) {
            entries.push((Sign::Line(EXACT), "exact"));
        }
        let header = Header::new(&self.title, &entries, WIDTH);
        canvas::svg((WIDTH, header.height() + HEIGHT), |root| {
            let (above, below) = root.split_vertically(header.height() * canvas::FINE);
            header.draw(&above)?;
            panel.draw(&below, &layers)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(count: u64) -> History {
        let mut history = History::default();
        for k in 0..count {
            let time = k as f64;
            history.push(Reading { time, value: 2.0 * time, exact: None });
        }
        history
    }

    fn trace(name: &str, curve: &[(f64, f64)]) -> Trace {
        Trace { name: name.to_owned(), history: history(5), curve: curve.to_vec() }
    }

    #[test]
    fn a_long_history_keeps_its_first_its_last_and_some_at_equal_distance() {
        for count in [0, 1, 3, 1999, 2000, 2001, 4096, 100_001] {
            let history = history(count);
            let times: Vec<f64> = history.readings().map(|reading| reading.time).collect();
            assert_eq!(history.count(), count);
            assert!(times.len() <= MOST_READINGS + 1, "{count}: {}", times.len());
            assert!(times.len() as u64 >= count.min(MOST_READINGS as u64 / 2), "{count}");
            assert_eq!(times.last().copied(), count.checked_sub(1).map(|k| k as f64));
            assert!(times.first().is_none_or(|first| *first == 0.0));
            let gaps: Vec<f64> = times.windows(2).map(|two| two[1] - two[0]).collect();
            let inner = &gaps[..gaps.len().saturating_sub(1)];
            assert!(inner.iter().all(|gap| *gap == inner[0]), "{count}");
        }
        assert_eq!(history(2000).readings().count(), 2000, "nothing goes before it has to");
    }

    #[test]
    fn exact_curves_are_drawn_where_there_are_some() {
        let of = |traces: Vec<Trace>| {
            let title = "a <b>".to_owned();
            HistoryPlot { title, traces, ..HistoryPlot::default() }.to_svg().unwrap()
        };
        let plain = of(vec![trace("one", &[]), trace("two", &[])]);
        let exact = of(vec![trace("one", &[(0.0, 0.0), (4.0, 8.0)]), trace("two", &[])]);
        assert!(plain.contains("one") && plain.contains("two") && plain.contains("a &lt;b&gt;"));
        assert!(plain.contains("time (s)") && !plain.contains('√'));
        assert!(exact.contains("exact") && !plain.contains("exact"));
        let color = "#D95F02";
        assert!(exact.contains(color) && !plain.contains(color));
    }

    #[test]
    fn the_square_root_of_time_straightens_a_root() {
        let mut history = History::default();
        for k in 0..5 {
            let time = f64::from(k * k);
            history.push(Reading { time, value: f64::from(k), exact: None });
        }
        let traces = vec![Trace { name: "front".to_owned(), history, curve: Vec::new() }];
        let plot = HistoryPlot { by_root: true, traces, ..HistoryPlot::default() };
        let gaps = |plot: &HistoryPlot| -> Vec<i64> {
            let svg = plot.to_svg().unwrap();
            let at = svg.match_indices("<circle cx=\"").map(|(k, sign)| &svg[k + sign.len()..]);
            let at: Vec<i64> =
                at.map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
            // The first one is that of the legend.
            at[1..].windows(2).map(|two| two[1] - two[0]).collect()
        };
        let even = |gaps: &[i64]| gaps.iter().all(|gap| (gap - gaps[0]).abs() <= 1);
        assert!(even(&gaps(&plot)), "{:?}", gaps(&plot));
        assert!(!even(&gaps(&HistoryPlot { by_root: false, ..plot })));
    }

    #[test]
    fn what_is_exact_and_far_beyond_the_readings_does_not_flatten_them() {
        let curve: Vec<(f64, f64)> = (1..50).map(|k| (0.1 * f64::from(k), 10.0)).collect();
        let low = trace("one", &curve);
        let mut high = low.clone();
        high.curve[0].1 = 1e9;
        let svg = |trace: Trace| {
            HistoryPlot { traces: vec![trace], ..HistoryPlot::default() }.to_svg().unwrap()
        };
        let dots = |svg: &str| -> Vec<String> {
            svg.lines().filter(|line| line.contains("<circle")).map(str::to_owned).collect()
        };
        let (low, high) = (svg(low), svg(high));
        assert_eq!(dots(&low), dots(&high));
        assert!(!high.contains("×10⁹"));
    }

    #[test]
    fn more_traces_than_colours_and_none_at_all_are_drawn() {
        for count in [0, 1, HistoryPlot::MOST_TRACES + 1] {
            let traces = (0..count).map(|k| trace(&format!("probe {k}"), &[])).collect();
            let svg = HistoryPlot { traces, ..HistoryPlot::default() }.to_svg().unwrap();
            assert_eq!(svg.matches("probe ").count(), count.min(HistoryPlot::MOST_TRACES));
        }
    }
}
