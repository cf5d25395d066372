//! `profile.svg`: the field along a line through the scene, against the exact solution.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::output::{OutputError, write_whole};
use super::plot;

/// Values along a line, for a plot of them and of their error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    /// The title above the plot.
    pub title: String,
    /// Name and unit of the horizontal axis: `x (m)`.
    pub axis_label: String,
    /// A point of the line: its y and z are those of every point of it (m).
    pub through: DVec3,
    /// The particles of the line, by ascending position.
    pub particles: Vec<usize>,
    /// Where along the line each particle is, m, ascending.
    pub position: Vec<f64>,
    /// The values themselves.
    pub values: Along,
    /// The enthalpy of a unit volume, where the scene melts: a panel of its own.
    pub enthalpy: Option<Along>,
}

/// What the particles of a line have, and what they should have.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Along {
    /// Its name, and unit if any: `temperature (K)`.
    pub label: String,
    /// The numerical value of each particle.
    pub value: Vec<f64>,
    /// The exact value at each particle, where there is an exact solution.
    pub exact: Option<Vec<f64>>,
    /// The exact solution as a curve of positions (m, ascending) and values, for a smoother line
    /// than the one through `exact`.
    pub exact_curve: Option<(Vec<f64>, Vec<f64>)>,
}

impl Profile {
    /// The row of particles along x that is nearest to the point `through` (m), by ascending x.
    ///
    /// A particle belongs to the row if its y and z are within half a `spacing` (m) of the point.
    /// Where several lattice rows do, midway between them, it is the nearest one, and among equals
    /// that of lowest y, then z. `None` if fewer than two particles belong.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn along_x(
        positions: &[DVec3],
        value: &[f64],
        exact: Option<&[f64]>,
        through: DVec3,
        spacing: f64,
    ) -> Option<Self> {
        assert_eq!(positions.len(), value.len(), "one value for every particle");
        assert!(exact.is_none_or(|e| e.len() == value.len()), "one exact value for every particle");
        let row = row_along_x(positions, through, spacing);
        (row.len() >= 2).then(|| {
            let pick = |field: &[f64]| row.iter().map(|&i| field[i]).collect();
            let values = Along {
                label: "value".to_owned(),
                value: pick(value),
                exact: exact.map(pick),
                exact_curve: None,
            };
            Self {
                axis_label: "x (m)".to_owned(),
                through: positions[row[0]],
                position: row.iter().map(|&i| positions[i].x).collect(),
                particles: row,
                values,
                ..Self::default()
            }
        })
    }

    /// The plot as SVG: values above, then the enthalpy where there is one, then the error of the
    /// values where there is an exact solution.
    pub fn to_svg(&self) -> io::Result<String> {
        plot::svg(self).map_err(io::Error::other)
    }

    /// Writes `profile.svg` into `folder` and returns its path.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, OutputError> {
        let path = folder.join("profile.svg");
        write_whole(&path, |out| out.write_all(self.to_svg()?.as_bytes()))?;
        Ok(path)
    }
}

/// Indices of the row nearest to `through`, one for every x, by ascending x.
fn row_along_x(positions: &[DVec3], through: DVec3, spacing: f64) -> Vec<usize> {
    let reach = 0.5 * spacing * (1.0 + 1e-9);
    let same = 1e-6 * spacing;
    let near = |p: &DVec3| (p.y - through.y).abs() <= reach && (p.z - through.z).abs() <= reach;
    let mut row: Vec<usize> = (0..positions.len()).filter(|&i| near(&positions[i])).collect();
    // Whole units of `same`, so that rounding does not decide between rows at equal distance.
    let key = |p: DVec3, to: DVec3| {
        let distance = (p.y - to.y).hypot(p.z - to.z);
        ((distance / same).round(), p.y, p.z)
    };
    let by_key = |a: usize, b: usize, to: DVec3| {
        let (a, b) = (key(positions[a], to), key(positions[b], to));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.total_cmp(&b.2))
    };
    let Some(anchor) = row.iter().copied().min_by(|&a, &b| by_key(a, b, through)) else {
        return row;
    };
    // Every x takes the particle nearest to the same line, so that the row does not change lanes.
    let line = positions[anchor];
    row.sort_by(|&a, &b| positions[a].x.total_cmp(&positions[b].x));
    row.chunk_by(|&a, &b| positions[b].x - positions[a].x <= same)
        .filter_map(|at_x| at_x.iter().copied().min_by(|&a, &b| by_key(a, b, line)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lattice of 5 x 4 x 3 with spacing 0.1 and x running fastest downwards.
    fn lattice() -> Vec<DVec3> {
        let cell = |i: usize| DVec3::new((4 - i % 5) as f64, (i / 5 % 4) as f64, (i / 20) as f64);
        (0..60).map(|i| 0.1 * cell(i) + DVec3::splat(0.05)).collect()
    }

    fn row(through: DVec3) -> Vec<f64> {
        let positions = lattice();
        let value: Vec<f64> = positions.iter().map(|p| 100.0 * p.y + p.z).collect();
        let profile = Profile::along_x(&positions, &value, Some(&value), through, 0.1).unwrap();
        assert_eq!(profile.position.len(), 5);
        assert!(profile.position.is_sorted_by(|a, b| a < b));
        let row: Vec<f64> = profile.particles.iter().map(|&i| value[i]).collect();
        assert_eq!((profile.values.exact.as_ref(), &row), (Some(&row), &profile.values.value));
        profile.values.value
    }

    #[test]
    fn takes_the_one_row_nearest_to_the_point() {
        assert_eq!(row(DVec3::new(9.0, 0.17, 0.24)), [100.0 * (0.1 + 0.05) + 0.2 + 0.05; 5]);
        assert_ne!(row(DVec3::new(9.0, 0.22, 0.24)), row(DVec3::new(9.0, 0.17, 0.24)));
    }

    #[test]
    fn midway_between_four_rows_it_stays_in_the_lowest() {
        assert_eq!(row(DVec3::new(0.0, 0.2, 0.1)), [100.0 * (0.1 + 0.05) + 0.05; 5]);
    }

    #[test]
    fn there_is_no_row_far_away_or_of_one_particle() {
        let positions = lattice();
        let value = vec![0.0; positions.len()];
        let far = DVec3::new(0.0, 5.0, 0.0);
        assert_eq!(Profile::along_x(&positions, &value, None, far, 0.1), None);
        let one = Profile::along_x(&positions[..1], &value[..1], None, positions[0], 0.1);
        assert_eq!(one, None);
        assert!(Profile::along_x(&positions[..2], &value[..2], None, positions[0], 0.1).is_some());
    }

    fn along(value: Vec<f64>, exact: Option<Vec<f64>>) -> Along {
        Along { label: "value".to_owned(), value, exact, exact_curve: None }
    }

    #[test]
    fn the_enthalpy_has_a_panel_of_its_own_where_there_is_one() {
        let values = along(vec![1.0, 2.0, 4.0], Some(vec![1.0, 2.5, 4.0]));
        let position = vec![0.0, 1.0, 2.0];
        let plain = Profile { position, values: values.clone(), ..Profile::default() };
        let enthalpy = Along { label: "enthalpy (J/m³)".to_owned(), ..values };
        let melting = Profile { enthalpy: Some(enthalpy), ..plain.clone() };
        let (plain, melting) = (plain.to_svg().unwrap(), melting.to_svg().unwrap());
        assert!(melting.contains("enthalpy (J/m³)") && !plain.contains("enthalpy"));
        assert_eq!(melting.matches("<circle").count(), plain.matches("<circle").count() + 3);
        // The error is that of the value alone, and is the last panel.
        for svg in [&plain, &melting] {
            assert_eq!(svg.matches("numerical − exact").count(), 1);
        }
        let place = |text: &str| melting.find(text).unwrap();
        assert!(place("enthalpy (J/m³)") < place("numerical − exact"));
    }

    #[test]
    fn the_plot_has_an_error_panel_only_with_an_exact_solution() {
        let mut profile = Profile {
            title: "a <b> & c".into(),
            axis_label: "x (m)".into(),
            position: vec![0.0, 1.0, 2.0],
            values: along(vec![1.0, f64::NAN, 3.0], None),
            ..Profile::default()
        };
        let svg = profile.to_svg().unwrap();
        assert!(svg.contains("a &lt;b&gt; &amp; c"));
        assert!(svg.contains("numerical") && !svg.contains("exact"));
        profile.values.exact = Some(vec![1.0, 2.0, 2.5]);
        assert!(profile.to_svg().unwrap().contains("largest not finite"));
        profile.values.value[1] = 2.0;
        let svg = profile.to_svg().unwrap();
        assert!(svg.contains("exact") && svg.contains("largest 0.5"), "{svg}");
    }

    #[test]
    fn ranges_without_extent_and_empty_profiles_are_drawn() {
        for value in [vec![], vec![1000.0; 4], vec![0.0; 4], vec![f64::NAN; 4], vec![1e300; 4]] {
            let position = (0..value.len()).map(|i| i as f64).collect();
            let values = along(value.clone(), Some(value));
            let enthalpy = Some(values.clone());
            let profile = Profile { position, values, enthalpy, ..Profile::default() };
            assert!(profile.to_svg().unwrap().ends_with("</svg>\n"));
        }
    }

    #[test]
    fn a_very_long_row_makes_a_small_file() {
        let position: Vec<f64> = (0..200_000).map(|i| i as f64 * 1e-3).collect();
        let value: Vec<f64> = position.iter().map(|x| x.sin()).collect();
        let values = along(value.clone(), Some(value));
        let mut profile = Profile { position, values, ..Profile::default() };
        assert!(profile.to_svg().unwrap().len() < 1_500_000);
        // The one particle that is wrong is still there.
        profile.values.value[123_456] += 0.25;
        assert!(profile.to_svg().unwrap().contains("largest 0.25"));
    }
}
