use super::left_out::PARTICLE_BYTES;
use super::*;
use crate::model::scenes::lattice;
use crate::model::{Condition, Conductivity, Face, KernelKind, Material, ScalarField, Wall};
use crate::solver::Precision;

fn what(problem: &Problem, machine: MachineKind) -> Vec<(&'static str, u64)> {
    let plan = Plan::new(problem, machine, &PathChoice::List(None), 0);
    plan.left_out.iter().map(|left| (left.what, left.bytes_saved)).collect()
}

#[test]
fn a_plain_scene_leaves_everything_out() {
    let problem = lattice(KernelKind::CubicSpline, 3, [4, 4, 4], 0.5, 2.0);
    let expected = [
        ("volume and properties by particle", 1024),
        ("nearest images", 0),
        ("wall fold", 0),
        ("exchange of held particles", 512),
        ("enthalpy", 768),
    ];
    assert_eq!(what(&problem, MachineKind::Gpu(Precision::F32)), expected);
}

#[test]
fn a_list_that_nobody_asked_for_gives_way_to_a_search() {
    let problem = lattice(KernelKind::CubicSpline, 3, [4, 4, 4], 0.5, 2.0);
    let gpu = MachineKind::Gpu(Precision::F32);
    let plan = |machine, choice| Plan::new(&problem, machine, &choice, 1000);
    let listed = plan(gpu, PathChoice::List(Some("moved")));
    let searched = listed.matrix_free(&problem, 1000).expect("a plan");
    assert_eq!((searched.path, searched.why_no_lattice), (Path::MatrixFree, Some("moved")));
    assert_eq!(listed.memory_bytes(&problem, 1000), 8 * 1000 + 64 * 20);
    assert_eq!(searched.memory_bytes(&problem, 1000), 64 * (12 + 8 + 12));
    let passes = searched.passes(&problem);
    assert!(passes.contains(&"gather") && !passes.contains(&"list"), "{passes:?}");
    for kept in
        [plan(gpu, PathChoice::List(None)), plan(MachineKind::Cpu, PathChoice::List(Some("moved")))]
    {
        assert_eq!(kept.matrix_free(&problem, 1000), None);
    }
}

#[test]
fn a_scene_that_needs_everything_leaves_nothing_out() {
    let mut problem = lattice(KernelKind::CubicSpline, 3, [4, 4, 4], 0.5, 2.0);
    problem.held = vec![0];
    problem.domain.periodic = [true, false, false];
    problem.particles.volume[5] *= 2.0;
    let value = Condition::value(ScalarField::new("t", |_, t| t));
    problem.walls = vec![wall(value)];
    let conductivity = Conductivity::of_points(vec![[0.0, 1.0], [100.0, 2.0]]);
    problem.materials = vec![Material::thermal("m", &conductivity, 1.0, None, 1.0)];
    // But for the ghosts of the 32 particles near the wall.
    let ghosts = ("ghost particles", 32 * PARTICLE_BYTES);
    assert_eq!(what(&problem, MachineKind::Gpu(Precision::F64)), [ghosts]);
}

fn wall(condition: Condition) -> Wall {
    let face = Face { axis: 1, upper: true };
    Wall { name: "wall".into(), face, covers: None, condition }
}

#[test]
fn walls_are_folded_and_evaluated_no_more_than_they_need() {
    let mut problem = lattice(KernelKind::CubicSpline, 2, [4, 4, 1], 0.5, 2.0);
    let mut found = |condition: Condition| {
        problem.walls = vec![wall(condition)];
        let plan = Plan::new(&problem, MachineKind::Cpu, &PathChoice::List(None), 0);
        let has = |what: &str| plan.left_out.iter().any(|left| left.what == what);
        let passes = plan.passes(&problem);
        let runs = |pass: &str| passes.contains(&pass);
        let left = [has("wall fold"), has("wall sources"), has("sources at every step")];
        (left, [runs("wall_fold"), runs("exchange"), runs("sources")])
    };
    let changing = ScalarField::new("t", |_, t| t);
    let steady = ScalarField::constant(3.0);
    assert_eq!(found(Condition::free()), ([true, false, false], [false, false, false]));
    assert_eq!(found(Condition::insulated()), ([false, true, false], [true, false, false]));
    assert_eq!(found(Condition::flux(steady)), ([false, false, true], [true, true, false]));
    assert_eq!(found(Condition::value(changing)), ([false, false, false], [true, true, true]));
}

#[test]
fn materials_of_one_diffusivity_count_as_one() {
    let mut problem = lattice(KernelKind::CubicSpline, 2, [4, 4, 1], 0.5, 2.0);
    problem.materials.push(problem.materials[0].clone());
    assert!(!Needs::of(&problem).coefficients);
    problem.materials[1].conductivity *= 2.0;
    assert!(!Needs::of(&problem).coefficients, "no particle is made of it");
    problem.particles.material[3] = 1;
    assert!(Needs::of(&problem).coefficients);
}
