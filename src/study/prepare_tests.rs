use super::*;
use crate::gpu::GpuError;
use crate::model::KernelKind;
use crate::model::scenes::lattice;
use crate::solver::Precision;

#[test]
fn a_list_without_room_gives_way_unless_it_was_asked_for() {
    let problem = lattice(KernelKind::CubicSpline, 2, [4, 4, 1], 0.5, 2.0);
    let machine = MachineKind::Gpu(Precision::F32);
    let build = |fits_list: bool| {
        move |matrix_free: bool| match fits_list || matrix_free {
            true => Ok(matrix_free),
            false => {
                let what = "weights".to_owned();
                Err(SolverError::from(GpuError::OutOfMemory { what, needed: 1 }))
            }
        }
    };
    for (why, fits_list, expected) in [
        (Some("moved"), true, Some((false, Path::List))),
        (Some("moved"), false, Some((true, Path::MatrixFree))),
        (None, true, Some((false, Path::List))),
        (None, false, None),
    ] {
        let choice = PathChoice::List(why);
        let (prepared, _) = prepare(&problem, machine, choice, false, false).expect("a good scene");
        let found = by_neighbors(&problem, prepared, build(fits_list)).ok();
        let found = found.map(|(prepared, matrix_free)| (matrix_free, prepared.plan.path));
        assert_eq!(found, expected, "{why:?}, {fits_list}");
    }
}
