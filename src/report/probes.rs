//! `probes.csv`: the value at named places over time.

use std::path::Path;

use glam::DVec3;

use super::growing_table::{GrowingTable, number};
use super::output::OutputError;

/// The value at one place and time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeRecord<'a> {
    /// Time, s.
    pub time: f64,
    /// The probe's name in the case file.
    pub name: &'a str,
    /// Position, m.
    pub at: DVec3,
    /// The numerical value.
    pub value: f64,
    /// The exact value, where the case has an exact solution.
    pub exact: Option<f64>,
}

/// Writes `probes.csv`: columns `time_s, name, x, y, z` (as many as the scene has dimensions),
/// `value, exact` (empty where there is none).
///
/// The file grows while the run goes on and is complete up to the last [`Self::write`].
#[derive(Debug)]
pub struct ProbeWriter {
    dimension: usize,
    table: GrowingTable,
}

impl ProbeWriter {
    /// Starts `probes.csv` in `folder`, replacing an earlier one; `dimension` is 1, 2 or 3.
    pub fn create(folder: &Path, dimension: usize) -> Result<Self, OutputError> {
        let axes = &["x", "y", "z"][..dimension];
        let columns = [&["time_s", "name"], axes, &["value", "exact"]].concat();
        let table = GrowingTable::create(folder.join("probes.csv"), &columns)?;
        Ok(Self { dimension, table })
    }

    /// Appends records; they are in the file when this returns.
    pub fn write(&mut self, records: &[ProbeRecord<'_>]) -> Result<(), OutputError> {
        for record in records {
            let mut row = vec![number(record.time), record.name.to_owned()];
            row.extend(record.at.to_array()[..self.dimension].iter().map(|&x| number(x)));
            row.push(number(record.value));
            row.push(record.exact.map_or_else(String::new, number));
            self.table.row(&row)?;
        }
        self.table.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_follow_the_dimension_and_numbers_read_back_exactly() {
        let folder = tempfile::tempdir().unwrap();
        let value = 0.1 + 0.2;
        let at = DVec3::new(25.25, 1e-7, 3.0);
        let record = ProbeRecord { time: 63_072_000.0, name: "a, \"b\"", at, value, exact: None };
        let text = |dimension| {
            let mut writer = ProbeWriter::create(folder.path(), dimension).unwrap();
            writer.write(&[record, ProbeRecord { exact: Some(0.3), ..record }]).unwrap();
            std::fs::read_to_string(folder.path().join("probes.csv")).unwrap()
        };
        assert_eq!(
            text(2),
            "time_s,name,x,y,value,exact\n\
             63072000.0,\"a, \"\"b\"\"\",25.25,1e-7,0.30000000000000004,\n\
             63072000.0,\"a, \"\"b\"\"\",25.25,1e-7,0.30000000000000004,0.3\n"
        );
        assert!(text(1).starts_with("time_s,name,x,value,exact\n"));
        assert!(text(3).starts_with("time_s,name,x,y,z,value,exact\n"));
    }

    #[test]
    fn says_which_file_cannot_be_written() {
        let error = ProbeWriter::create(Path::new("/nowhere/at/all"), 3).unwrap_err();
        assert!(error.to_string().contains("/nowhere/at/all/probes.csv"), "{error}");
    }
}
