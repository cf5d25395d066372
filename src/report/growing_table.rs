//! A CSV file that grows while a run goes on.

use std::fs::File;
use std::path::PathBuf;

use super::output::OutputError;

/// A CSV file that is complete up to the last [`Self::flush`].
#[derive(Debug)]
pub(super) struct GrowingTable {
    path: PathBuf,
    table: csv::Writer<File>,
}

impl GrowingTable {
    /// Starts the file with its header, replacing an earlier one.
    pub(super) fn create(path: PathBuf, columns: &[&str]) -> Result<Self, OutputError> {
        let failed = |source| OutputError::Write { path: path.clone(), source };
        let table = csv::Writer::from_writer(File::create(&path).map_err(failed)?);
        let mut table = Self { path, table };
        table.row(columns)?;
        table.flush()?;
        Ok(table)
    }

    /// Appends a row.
    pub(super) fn row<T: AsRef<[u8]>>(
        &mut self,
        cells: impl IntoIterator<Item = T>,
    ) -> Result<(), OutputError> {
        let written = self.table.write_record(cells);
        written.map_err(|e| OutputError::Write { path: self.path.clone(), source: e.into() })
    }

    /// Has all rows in the file.
    pub(super) fn flush(&mut self) -> Result<(), OutputError> {
        let flushed = self.table.flush();
        flushed.map_err(|source| OutputError::Write { path: self.path.clone(), source })
    }
}

/// The shortest text that reads back as the same number.
pub(super) fn number(x: f64) -> String {
    format!("{x:?}")
}
