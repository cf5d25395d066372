//! What a step has to move and to compute for a particle, whatever the machine.

use crate::model::Problem;
use crate::model::lattice::LineClass;
use crate::solver::{MachineKind, PathChoice};

/// How the sum over neighbours is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sum {
    /// From a list.
    Listed,
    /// By a search in the cells around.
    Searched {
        /// 1, 2 or 3.
        dimension: usize,
        /// Particles in those cells.
        candidates: f64,
    },
    /// By a stencil of so many operations.
    Stencil(f64),
}

/// What a step costs a particle, on average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cost {
    /// Bytes that have to come from memory or go there.
    pub(super) bytes: f64,
    /// Those of them that come from there.
    pub(super) read: f64,
    /// Additions, subtractions and multiplications, of one word where a state has two.
    pub(super) operations: f64,
}

/// Operations of u + dt x rate.
const EULER: f64 = 2.0;

/// Bytes of a neighbour's index, and of where a row begins or how long it is.
const INDEX: f64 = 4.0;

impl Cost {
    /// That of a particle with `neighbors` neighbours.
    pub(super) fn new(machine: MachineKind, neighbors: f64, sum: Sum) -> Self {
        let precision = machine.precision();
        let state = precision.state_bytes() as f64;
        let real = precision.bytes() as f64;
        match sum {
            Sum::Listed => Self::of_list(real, state, neighbors),
            Sum::Searched { dimension, candidates } => {
                let axes = dimension as f64;
                Self::of_search(real, state, neighbors, axes, candidates)
            }
            Sum::Stencil(operations) => Self::of_stencil(state, operations),
        }
    }

    /// The place of the particle in its cell and the cell, one state read and one written: what lies around
    /// comes from a cache. A candidate takes, along each axis, a difference, a scale and a square that is
    /// added; a neighbour about ten operations for its weight, and three as in a list.
    fn of_search(real: f64, state: f64, neighbors: f64, axes: f64, candidates: f64) -> Self {
        let operations = 4.0 * axes * candidates + 13.0 * neighbors + EULER;
        Self::of_reading(axes * real + INDEX + state, state, operations)
    }

    /// Of each neighbour its index and its weight, of each row where it begins, and one state read
    /// and one written: a neighbour's value comes from a cache, where an earlier row has left it.
    /// A neighbour takes a difference, a multiplication and an addition.
    fn of_list(real: f64, state: f64, neighbors: f64) -> Self {
        let entries = neighbors * (INDEX + real) + INDEX;
        Self::of_reading(entries + state, state, 3.0 * neighbors + EULER)
    }

    /// One state read and one written: neighbours come from a cache, weights from registers.
    fn of_stencil(state: f64, operations: f64) -> Self {
        Self::of_reading(state, state, operations + EULER)
    }

    fn of_reading(read: f64, written: f64, operations: f64) -> Self {
        Self { bytes: read + written, read, operations }
    }
}

/// How the sum of `problem` is made along `choice`; the operations of a stencil are those far from edges, as
/// the CPU factors the sum (`src/solver/cpu/lattice/kernel.rs`) or as the shaders write it out.
pub(super) fn sum(problem: &Problem, choice: &PathChoice, machine: MachineKind) -> Sum {
    match choice {
        PathChoice::Lattice(scene) => {
            let operations = match machine {
                MachineKind::Cpu => factored(&scene.classes),
                MachineKind::Gpu(_) => written_out(&scene.classes),
            };
            Sum::Stencil(operations as f64)
        }
        PathChoice::MatrixFree(_) => {
            let cell = problem.kernel.support_radius() / problem.spacing;
            let dimension = problem.dimension;
            Sum::Searched { dimension, candidates: (3.0 * cell).powi(dimension as i32) }
        }
        PathChoice::List(_) | PathChoice::Mixed(..) => Sum::Listed,
    }
}

/// The lines of a class are added up (n - 1 operations) and n C is taken off (2); each weight adds
/// its part (2). The class of the line itself has nothing to add up but for its weights, which are
/// part of what follows: a step along x takes 2 for K C and 4 for both sides.
fn factored(classes: &[LineClass]) -> usize {
    let others = classes.iter().filter(|class| !is_own(class));
    let of_class = |class: &LineClass| class.lines.len() + 1 + 2 * weights(class).count();
    let reach = classes.iter().map(|class| class.weights.len() - 1).max().unwrap_or(0);
    others.map(of_class).sum::<usize>() + 6 * reach
}

/// Differences (1 a neighbour) of one weight are added up (1), then multiplied by it (1).
fn written_out(classes: &[LineClass]) -> usize {
    let of_class = |class: &LineClass| {
        let sides = |step: usize| if step == 0 { 1 } else { 2 };
        weights(class).map(|step| 2 * class.lines.len() * sides(step) + 1).sum::<usize>()
    };
    classes.iter().map(of_class).sum()
}

/// Whether it is the line of the particle itself.
fn is_own(class: &LineClass) -> bool {
    class.lines == [[0, 0]]
}

/// The steps along x with a weight.
fn weights(class: &LineClass) -> impl Iterator<Item = usize> + '_ {
    (0..class.weights.len()).filter(|&step| class.weights[step] != 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::scene::scene;
    use super::*;
    use crate::solver::{PathWish, Precision};

    fn cost(path: PathWish, dimension: usize, support_ratio: f64, neighbors: f64) -> Cost {
        let problem = scene(1000, dimension, support_ratio);
        let choice = PathChoice::new(&problem, MachineKind::Cpu, path).expect("it is a lattice");
        Cost::new(MachineKind::Cpu, neighbors, sum(&problem, &choice, MachineKind::Cpu))
    }

    #[test]
    fn a_list_moves_its_entries_and_a_lattice_two_states() {
        let list = cost(PathWish::List, 3, 2.0, 26.0);
        assert_eq!(list, Cost::of_reading(26.0 * 12.0 + 4.0 + 8.0, 8.0, 80.0));
        assert_eq!(list.bytes, 332.0);
        assert!(cost(PathWish::List, 3, 2.0, 27.0).bytes > list.bytes);
        let lattice = cost(PathWish::Lattice, 3, 2.0, 26.0);
        assert_eq!(lattice.bytes, 16.0);
        assert_eq!(cost(PathWish::Lattice, 3, 3.0, 92.0).bytes, 16.0, "whatever the support");
        let device = MachineKind::Gpu(Precision::F32);
        let list = Cost::new(device, 26.0, Sum::Listed);
        assert_eq!(list.bytes, 26.0 * 8.0 + 4.0 + 8.0);
        let searched = Sum::Searched { dimension: 3, candidates: 216.0 };
        assert_eq!(sum(&scene(1000, 3, 2.0), &PathChoice::MatrixFree(None), device), searched);
        let search = Cost::new(device, 26.0, searched);
        assert_eq!(search, Cost::of_reading(12.0 + 4.0 + 4.0, 4.0, 12.0 * 216.0 + 340.0));
    }

    #[test]
    fn a_stencil_takes_the_operations_of_its_classes() {
        // Of the nine points of H/dx = 2 in 2-D: two other lines are added up (1), less 2 C (2),
        // with two weights (4); the step along x (6); Euler's 2.
        assert_eq!(cost(PathWish::Lattice, 2, 2.0, 8.0).operations, 15.0);
        // In 3-D there are two classes of four lines (3 + 2 + 4 each) and one step.
        assert_eq!(cost(PathWish::Lattice, 3, 2.0, 26.0).operations, 26.0);
        let problem = scene(1000, 3, 2.0);
        let device = MachineKind::Gpu(Precision::F32);
        let choice = PathChoice::new(&problem, device, PathWish::Lattice).expect("a lattice");
        // 26 neighbours of five weights: one on the line itself, two in each class.
        assert_eq!(sum(&problem, &choice, device), Sum::Stencil(2.0 * 26.0 + 5.0));
        let mut classes = [LineClass { lines: vec![[0, 1]], weights: vec![3.0, 2.0, 1.0] }];
        assert_eq!((factored(&classes), written_out(&classes)), (20, 13));
        classes[0].weights[1] = 0.0;
        assert_eq!((factored(&classes), written_out(&classes)), (18, 8));
    }
}
