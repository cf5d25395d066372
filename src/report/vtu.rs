//! Fields for ParaView, pyvista and meshio: one `.vtu` file an output, and `series.pvd` over all.
//!
//! The files are VTK XML unstructured grids with inline base64 arrays and one VERTEX cell a
//! particle. They are written here and not by the `vtkio` crate: `vtkio` 0.6.3 reads well in both
//! readers, but holds every array several times over (290 bytes a particle for one field, more for
//! each further one, where this writer streams through fixed buffers), and takes several times as
//! long.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use glam::DVec3;

use super::output::{OutputError, write_whole};

/// VTK's number for a cell of one point.
const VTK_VERTEX: u8 = 1;
/// Entries of a generated array (connectivity, offsets, types) that are held at a time.
const CHUNK: usize = 8192;
/// Arrays are written in the byte order of the machine, so that they need no conversion.
const BYTE_ORDER: &str = if cfg!(target_endian = "little") { "LittleEndian" } else { "BigEndian" };

/// Writes `particles_0000.vtu`, `particles_0001.vtu`, ... and `series.pvd` into one folder.
///
/// `series.pvd` is rewritten after every output, so that an interrupted run can be read.
#[derive(Debug)]
pub struct SeriesWriter {
    folder: PathBuf,
    /// Time (s) and file name of every output so far.
    written: Vec<(f64, String)>,
}

impl SeriesWriter {
    /// A series in `folder`, which must exist. Writes nothing yet.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into(), written: Vec::new() }
    }

    /// Writes the fields at `time` (s) and returns the path of the `.vtu` file.
    ///
    /// `positions` in m; each field is a name and one value a particle.
    pub fn write(
        &mut self,
        time: f64,
        positions: &[DVec3],
        fields: &[(&str, &[f64])],
    ) -> Result<PathBuf, OutputError> {
        let name = format!("particles_{:04}.vtu", self.written.len());
        let path = self.folder.join(&name);
        write_whole(&path, |out| write_vtu(out, positions, fields))?;
        self.written.push((time, name));
        write_whole(&self.collection(), |out| self.write_pvd(out))?;
        Ok(path)
    }

    /// The path of `series.pvd`, which lists time and file of every output.
    pub fn collection(&self) -> PathBuf {
        self.folder.join(Path::new("series.pvd"))
    }

    fn write_pvd(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, r#"<?xml version="1.0"?>"#)?;
        writeln!(out, r#"<VTKFile type="Collection" version="1.0" byte_order="{BYTE_ORDER}">"#)?;
        writeln!(out, "<Collection>")?;
        for (time, name) in &self.written {
            // `{:?}` is the shortest text that reads back as the same number.
            writeln!(out, r#"<DataSet timestep="{time:?}" part="0" file="{name}"/>"#)?;
        }
        writeln!(out, "</Collection>\n</VTKFile>")
    }
}

fn write_vtu(
    out: &mut impl Write,
    positions: &[DVec3],
    fields: &[(&str, &[f64])],
) -> io::Result<()> {
    let count = positions.len();
    writeln!(out, r#"<?xml version="1.0"?>"#)?;
    write!(out, r#"<VTKFile type="UnstructuredGrid" version="1.0" "#)?;
    writeln!(out, r#"byte_order="{BYTE_ORDER}" header_type="UInt64">"#)?;
    writeln!(out, "<UnstructuredGrid>")?;
    writeln!(out, r#"<Piece NumberOfPoints="{count}" NumberOfCells="{count}">"#)?;
    writeln!(out, "<PointData>")?;
    for (name, values) in fields {
        if values.len() != count {
            let message = format!("field {name}: {} values, {count} particles", values.len());
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        let attributes = format!(r#"type="Float64" Name="{}""#, escaped(name));
        write_array(out, &attributes, size_of_val(*values), |data| {
            data.write_all(bytemuck::cast_slice(values))
        })?;
    }
    writeln!(out, "</PointData>\n<Points>")?;
    let attributes = r#"type="Float64" Name="Points" NumberOfComponents="3""#;
    write_array(out, attributes, size_of_val(positions), |data| {
        data.write_all(bytemuck::cast_slice(positions))
    })?;
    writeln!(out, "</Points>\n<Cells>")?;
    write_cells(out, count)?;
    writeln!(out, "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")
}

/// One VERTEX cell a particle: cell i holds point i alone, and ends at offset i + 1.
fn write_cells(out: &mut impl Write, count: usize) -> io::Result<()> {
    for (name, first) in [("connectivity", 0), ("offsets", 1)] {
        let attributes = format!(r#"type="Int64" Name="{name}""#);
        write_array(out, &attributes, size_of::<i64>() * count, |data| {
            for start in (0..count).step_by(CHUNK) {
                let end = (start + CHUNK).min(count);
                let chunk: Vec<i64> = (start..end).map(|i| i as i64 + first).collect();
                data.write_all(bytemuck::cast_slice(&chunk))?;
            }
            Ok(())
        })?;
    }
    write_array(out, r#"type="UInt8" Name="types""#, count, |data| {
        for start in (0..count).step_by(CHUNK) {
            data.write_all(&[VTK_VERTEX; CHUNK][..CHUNK.min(count - start)])?;
        }
        Ok(())
    })
}

/// One `DataArray`: its length in bytes as a 64-bit header and the data, as one base64 text.
fn write_array<W: Write>(
    out: &mut W,
    attributes: &str,
    bytes: usize,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    write!(out, r#"<DataArray {attributes} format="binary">"#)?;
    let mut data = EncoderWriter::new(&mut *out, &STANDARD);
    data.write_all(&(bytes as u64).to_ne_bytes())?;
    write(&mut data)?;
    let out = data.finish()?;
    writeln!(out, "</DataArray>")
}

/// A name as an XML attribute's value. XML itself would allow `>`, but VTK's reader takes the
/// first one for the end of the tag when it looks for the data.
fn escaped(name: &str) -> String {
    let name = name.replace('&', "&amp;").replace('"', "&quot;");
    name.replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_collection_is_complete_after_every_output() {
        let folder = tempfile::tempdir().unwrap();
        let mut series = SeriesWriter::new(folder.path());
        assert!(!series.collection().exists());
        for (k, time) in [0.0, 0.1, 6.3072e7].into_iter().enumerate() {
            let path = series.write(time, &[DVec3::ONE], &[("value", &[2.0])]).unwrap();
            assert_eq!(path, folder.path().join(format!("particles_000{k}.vtu")));
            let text = std::fs::read_to_string(series.collection()).unwrap();
            assert_eq!(text.matches("<DataSet").count(), k + 1);
            assert!(text.contains(&format!(r#"timestep="{time:?}""#)));
        }
    }

    #[test]
    fn a_field_of_the_wrong_length_is_refused_and_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let mut series = SeriesWriter::new(folder.path());
        let error = series.write(0.0, &[DVec3::ONE], &[("value", &[1.0, 2.0])]).unwrap_err();
        assert!(error.to_string().contains("field value: 2 values, 1 particles"), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn names_are_escaped() {
        assert_eq!(escaped(r#"<a> & "c""#), "&lt;a&gt; &amp; &quot;c&quot;");
    }
}
