//! `front.csv`: how far a body has melted, over time.

use std::path::Path;

use super::growing_table::{GrowingTable, number};
use super::output::OutputError;
use super::run::Front;

/// Writes `front.csv`: columns `time_s, position, liquid_volume, exact` as [`Front`] has them (the last
/// one empty where there is none).
///
/// The file grows while the run goes on and is complete up to the last [`Self::write`].
#[derive(Debug)]
pub struct FrontWriter {
    table: GrowingTable,
}

impl FrontWriter {
    /// Starts `front.csv` in `folder`, replacing an earlier one.
    pub fn create(folder: &Path) -> Result<Self, OutputError> {
        let columns = ["time_s", "position", "liquid_volume", "exact"];
        Ok(Self { table: GrowingTable::create(folder.join("front.csv"), &columns)? })
    }

    /// Appends the front at `time` (s); it is in the file when this returns.
    pub fn write(&mut self, time: f64, front: &Front) -> Result<(), OutputError> {
        let exact = front.exact.map_or_else(String::new, number);
        let numbers = [time, front.position, front.liquid_volume].map(number);
        self.table.row(numbers.into_iter().chain([exact]))?;
        self.table.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_there_at_once_and_read_back_exactly() {
        let folder = tempfile::tempdir().unwrap();
        let text = || std::fs::read_to_string(folder.path().join("front.csv")).unwrap();
        let mut writer = FrontWriter::create(folder.path()).unwrap();
        assert_eq!(text(), "time_s,position,liquid_volume,exact\n");
        let front = Front { position: 0.1 + 0.2, liquid_volume: 1e-7, exact: None };
        writer.write(2.0, &front).unwrap();
        writer.write(3.0, &Front { exact: Some(0.3), ..front }).unwrap();
        assert_eq!(
            text().lines().skip(1).collect::<Vec<_>>(),
            ["2.0,0.30000000000000004,1e-7,", "3.0,0.30000000000000004,1e-7,0.3"]
        );
    }
}
