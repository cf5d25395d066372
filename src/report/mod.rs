//! What a run leaves behind: norms and totals, `report.json`, fields for viewers, probes, profile.
//!
//! Nothing here prints, and nothing here knows how the numbers were computed: callers hand over
//! slices and get numbers, text or files back. Every file is written whole or not at all (see
//! [`output`]), apart from `probes.csv` and `front.csv`, which grow while the run goes on.

pub mod bench;
pub mod format;
pub mod front;
pub mod history;
pub mod html;
pub mod norms;
pub mod output;
pub mod probes;
pub mod profile;
pub mod run;
pub mod stability;
pub mod study;
pub mod sum;
pub mod vtu;

mod axis;
mod bench_table;
mod canvas;
mod growing_table;
mod header;
mod panel;
mod plot;
mod summary;

pub use bench::BenchReport;
pub use front::FrontWriter;
pub use history::{History, HistoryPlot, Reading, Trace};
pub use norms::{Norms, observed_order};
pub use output::{OutputError, OutputFolder};
pub use probes::{ProbeRecord, ProbeWriter};
pub use profile::{Along, Profile};
pub use run::RunReport;
pub use stability::StabilityReport;
pub use study::StudyReport;
pub use sum::total;
pub use vtu::SeriesWriter;
