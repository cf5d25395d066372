//! What a step has to move and to compute for a particle, whatever the machine.

use crate::model::lattice::LineClass;
use crate::solver::{MachineKind, PathChoice};

/// What a step costs a particle, on average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cost {
    /// Bytes that have to come from memory or go there.
    pub(super) bytes: f64,
    /// Additions, subtractions and multiplications.
    pub(super) operations: f64,
}

/// Operations of u + dt x rate.
const EULER: f64 = 2.0;

/// Bytes of a neighbour's index, and of where a row begins or how long it is.
const INDEX: f64 = 4.0;

impl Cost {
    /// That of a particle with `neighbors` neighbours: by list, or by a stencil of so many
    /// `operations`.
    pub(super) fn new(machine: MachineKind, neighbors: f64, stencil: Option<f64>) -> Self {
        let real = machine.precision().bytes() as f64;
        match stencil {
            None => Self::of_list(real, neighbors),
            Some(operations) => Self::of_stencil(real, operations),
        }
    }

    /// Of each neighbour its index and its weight, of each row where it begins, and one state read
    /// and one written: a neighbour's value comes from a cache, where an earlier row has left it.
    /// A neighbour takes a difference, a multiplication and an addition.
    fn of_list(real: f64, neighbors: f64) -> Self {
        Self {
            bytes: neighbors * (INDEX + real) + INDEX + 2.0 * real,
            operations: 3.0 * neighbors + EULER,
        }
    }

    /// One state read and one written: neighbours come from a cache, weights from registers.
    fn of_stencil(real: f64, operations: f64) -> Self {
        Self { bytes: 2.0 * real, operations: operations + EULER }
    }
}

/// Operations of the stencil of a choice that is a lattice: of the sum by classes of lines
/// (`src/solver/lattice/kernel.rs`), far from edges.
pub(super) fn stencil_operations(choice: &PathChoice) -> Option<f64> {
    match choice {
        PathChoice::List(_) => None,
        PathChoice::Lattice(scene) => {
            Some(scene.classes.iter().map(of_class).sum::<usize>() as f64)
        }
    }
}

/// The lines of a class are added up once; then w (R - n C) in the middle has four operations, and
/// w (R_lower + R_upper - 2 n C) at a step has five.
fn of_class(class: &LineClass) -> usize {
    let steps = class.weights[1..].iter().filter(|weight| **weight != 0.0).count();
    let middle = if class.weights[0] == 0.0 { 0 } else { 4 };
    class.lines.len() - 1 + middle + 5 * steps
}

#[cfg(test)]
mod tests {
    use super::super::scene::scene;
    use super::*;
    use crate::solver::{PathWish, Precision};

    fn cost(path: PathWish, dimension: usize, support_ratio: f64, neighbors: f64) -> Cost {
        let problem = scene(1000, dimension, support_ratio);
        let choice = PathChoice::new(&problem, MachineKind::Cpu, path).expect("it is a lattice");
        Cost::new(MachineKind::Cpu, neighbors, stencil_operations(&choice))
    }

    #[test]
    fn a_list_moves_its_entries_and_a_lattice_two_states() {
        let list = cost(PathWish::List, 3, 2.0, 26.0);
        assert_eq!(list, Cost { bytes: 26.0 * 12.0 + 4.0 + 16.0, operations: 80.0 });
        assert!(cost(PathWish::List, 3, 2.0, 27.0).bytes > list.bytes);
        let lattice = cost(PathWish::Lattice, 3, 2.0, 26.0);
        assert_eq!(lattice.bytes, 16.0);
        assert_eq!(cost(PathWish::Lattice, 3, 3.0, 92.0).bytes, 16.0, "whatever the support");
        let device = MachineKind::Gpu(Precision::F32);
        let list = Cost::new(device, 26.0, None);
        assert_eq!(list.bytes, 26.0 * 8.0 + 4.0 + 8.0);
    }

    #[test]
    fn a_stencil_takes_the_operations_of_its_classes() {
        // Of the nine points of H/dx = 2 in 2-D: the line itself has a pair beside the middle (5),
        // the class of the two others is added up (1) with middle (4) and pair (5); Euler's 2.
        assert_eq!(cost(PathWish::Lattice, 2, 2.0, 8.0).operations, 17.0);
        // In 3-D there are the line itself (5) and two classes of four lines (3 + 9 each).
        assert_eq!(cost(PathWish::Lattice, 3, 2.0, 26.0).operations, 31.0);
        let class = LineClass { lines: vec![[0, 0]], weights: vec![0.0, 2.0, 1.0] };
        assert_eq!(of_class(&class), 10);
        let shorter = LineClass { weights: vec![0.0, 2.0, 0.0], ..class };
        assert_eq!(of_class(&shorter), 5, "a weight of 0 takes nothing");
    }
}
