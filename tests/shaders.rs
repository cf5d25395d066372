//! Every combination of shader files is valid, checked without an adapter.

use std::collections::BTreeSet;

use diffusph::gpu::limits::{CHAIN, limit_sources};
use diffusph::gpu::{BlockLayout, PassSource, Real, scan_sources};
use diffusph::model::{KernelKind, PairMean};
use diffusph::solver::Precision;
use diffusph::solver::gpu::curve_passes::{CurveKind, CurvePasses, HeldIn, SeamPasses};
use diffusph::solver::gpu::lattice::{OwnRows, PART, StencilSource};
use diffusph::solver::gpu::passes::{
    CHUNK, COMBINATION, Choices, GRID, Neighbors, STEP_SIZE, WallTerms, finite, self_test, still,
};
use diffusph::solver::gpu::vector::{ENTRIES, PLACES, UPDATE, vector_passes};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Expression, MathFunction, Module, ScalarKind, TypeInner};

/// What GLSL.std.450 offers in f64 as well: not exp, log, pow and the trigonometric functions, which
/// naga accepts all the same.
const IN_F64: [MathFunction; 7] = [
    MathFunction::Abs,
    MathFunction::Min,
    MathFunction::Max,
    MathFunction::Floor,
    MathFunction::Round,
    MathFunction::Sqrt,
    MathFunction::Fma,
];

/// Checks a source up to its SPIR-V.
fn check(source: &str) -> Result<(), String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|e| e.emit_to_string(source))?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::FLOAT64);
    let info = validator.validate(&module).map_err(|e| e.emit_to_string(source))?;
    let named = module.functions.iter().map(|(handle, f)| (f, &info[handle]));
    let entry = module.entry_points.iter().enumerate();
    let entries = entry.map(|(i, e)| (&e.function, info.get_entry_point(i)));
    for (function, of_function) in named.chain(entries) {
        for (handle, expression) in function.expressions.iter() {
            let Expression::Math { fun, arg, .. } = *expression else {
                continue;
            };
            let inner = of_function[arg].ty.inner_with(&module.types);
            if is_f64(inner) && !IN_F64.contains(&fun) {
                return Err(format!("{fun:?} of f64 in expression {handle:?}"));
            }
        }
    }
    let options = naga::back::spv::Options::default();
    naga::back::spv::write_vec(&module, &info, &options, None).map_err(|e| e.to_string())?;
    Ok(())
}

fn is_f64(inner: &TypeInner) -> bool {
    let scalar = match *inner {
        TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } => scalar,
        _ => return false,
    };
    scalar.kind == ScalarKind::Float && scalar.width == 8
}

/// Every combination of choices that a scene can make.
fn combinations() -> Vec<Choices> {
    let mut all = Vec::new();
    for kernel in KernelKind::ALL {
        for pair_mean in PairMean::ALL {
            for precision in Precision::ALL {
                for dimension in (1..=3).filter(|&d| kernel.is_defined_in(d)) {
                    for bits in 0..(4 << dimension) {
                        let bit = |n: usize| bits >> n & 1 == 1;
                        all.extend(WallTerms::ALL.map(|walls| Choices {
                            kernel,
                            pair_mean,
                            dimension,
                            periodic: [0, 1, 2].map(|axis| axis < dimension && bit(2 + axis)),
                            held: bit(0),
                            walls,
                            uniform: bit(1),
                            neighbors: Neighbors::Listed,
                            precision,
                            workgroup_size: 64,
                        }));
                    }
                }
            }
        }
    }
    all
}

/// The same without a list, of one kernel: each is part of the list's passes too.
fn searches() -> impl Iterator<Item = Choices> {
    let is_one = |choices: &Choices| {
        (choices.kernel, choices.pair_mean) == (KernelKind::CubicSpline, PairMean::Harmonic)
    };
    combinations().into_iter().filter(is_one).flat_map(|choices| {
        // What walls add to a row is named by the fold.
        let folded = [false, true]
            .into_iter()
            .filter(move |folded| *folded || choices.walls == WallTerms::None);
        folded.map(move |folded| Choices { neighbors: Neighbors::Searched { folded }, ..choices })
    })
}

/// Lattices of every kind: the stencil is written out or a loop.
fn lattices() -> Vec<StencilSource> {
    let mut all = Vec::new();
    let beside = WallTerms::ALL.map(|walls| OwnRows::ALL.map(|rows| (walls, rows)));
    for precision in Precision::ALL {
        for &(walls, rows) in beside.as_flattened() {
            for bits in 0..32_u32 {
                let bit = |n: u32| bits >> n & 1 == 1;
                let neighbors: isize = if bit(0) { 200 } else { 4 };
                let entry = |k: isize| ([k % 5 - 2, k / 5 - 1, 0], 0.1 / (1 + k / 2) as f64);
                all.push(StencilSource {
                    counts: [9, 8, if bit(1) { 7 } else { 1 }],
                    reach: 2,
                    dimension: if bit(1) { 3 } else { 2 },
                    periodic: [bit(2), false, bit(1)],
                    mirrors: 0b1000,
                    entries: (0..neighbors).map(entry).collect(),
                    is_split: bit(3),
                    kinds: bit(4),
                    rows,
                    held: bit(2),
                    walls,
                    finds_each: false,
                    precision,
                    workgroup_size: 64,
                });
            }
        }
    }
    all
}

fn a_choice(precision: Precision) -> Choices {
    let mut all = combinations().into_iter();
    all.find(|choices| choices.precision == precision).expect("every precision is among them")
}

#[test]
fn every_combination_is_valid() {
    let mut seen = BTreeSet::new();
    let passes = combinations().into_iter().flat_map(|choices| choices.all());
    let passes = passes.chain(searches().flat_map(|choices| choices.all()));
    let passes = passes.chain(lattices().into_iter().flat_map(|lattice| lattice.all()));
    let on_states = |precision| {
        let looks = [finite(precision, 64), still(precision, 64)];
        let curves = CurveKind::all(precision).map(|kind| CurvePasses {
            precision,
            workgroup_size: 64,
            kind,
        });
        let seams = HeldIn::ALL.into_iter().flat_map(move |held| {
            PairMean::ALL.map(|pair_mean| SeamPasses {
                precision,
                workgroup_size: 64,
                pair_mean,
                held,
            })
        });
        let of_curves = curves.into_iter().flat_map(CurvePasses::all);
        looks.into_iter().chain(of_curves).chain(seams.flat_map(SeamPasses::all))
    };
    let passes = passes.chain(Precision::ALL.into_iter().flat_map(on_states));
    let passes = passes.chain(Precision::ALL.into_iter().flat_map(vector_passes));
    let passes = passes.chain([self_test()]);
    let passes = passes.chain(Real::ALL.into_iter().flat_map(limit_sources));
    for source in passes.chain(scan_sources()) {
        let text = source.link().expect("every file exists");
        if seen.insert(text.clone())
            && let Err(message) = check(&text)
        {
            panic!("{}: {message}", source.pass);
        }
    }
    assert!(seen.len() > 500, "{} sources", seen.len());
}

#[test]
fn a_step_has_an_enthalpy_only_where_that_is_the_state() {
    let names = |source: &PassSource| source.bindings.iter().map(|b| b.name).collect::<Vec<_>>();
    for precision in Precision::ALL {
        let lattice = lattices().into_iter().find(|lattice| lattice.precision == precision);
        let lattice = lattice.expect("every precision is among them").all();
        let on_lattice: Vec<_> = lattice.iter().filter(|s| s.pass == "lattice_step").collect();
        let choices = a_choice(precision);
        let of_list = CurveKind::all(precision).map(|kind| {
            let curve: &[_] = match kind {
                CurveKind::Phases(_) => &[],
                CurveKind::One => &["curve"],
                CurveKind::EachPhases => &["material_phases", "curve_of"],
                CurveKind::Each => &["curve", "curve_of", "curve_start"],
            };
            let curves = CurvePasses { precision, workgroup_size: 64, kind };
            let [enthalpy, noted] = [false, true].map(|kept| choices.enthalpy_step(curves, kept));
            (choices.step(), enthalpy, noted, curve)
        });
        let [plain, of_curves @ ..] = &on_lattice[..] else {
            panic!("no steps on a lattice");
        };
        assert_eq!(of_curves.len(), 2 * of_list.len());
        let on_lattice = of_curves.chunks(2).zip(&of_list);
        let on_lattice = on_lattice.map(|(step, (.., curve))| (*plain, step[0], step[1], *curve));
        let of_list =
            of_list.iter().map(|(plain, step, noted, curve)| (plain, step, noted, *curve));
        for (plain, enthalpy, noted, curve) in of_list.chain(on_lattice) {
            let text = plain.link().expect("every file exists");
            assert!(!text.contains("content") && !text.contains("curve"), "{text}");
            let expected = [&names(plain)[..], &["content", "content_after"], curve].concat();
            assert_eq!(names(enthalpy), expected);
            assert_eq!(names(noted), [&expected[..], &["tiles", "appended"]].concat());
        }
    }
}

#[test]
fn a_broken_slot_is_noticed() {
    for precision in Precision::ALL {
        let list = a_choice(precision).list().link().expect("every file exists");
        check(&list).expect("valid as it is");
        let signature = "fn kernel_shape_dw_over_r(q: real)";
        assert!(list.contains(signature));
        let wrong_name = list.replace(signature, "fn kernel_shape_dw(q: real)");
        let wrong_type = list.replace(signature, "fn kernel_shape_dw_over_r(q: vec2<real>)");
        assert!(check(&wrong_name).is_err() && check(&wrong_type).is_err());
        // SPIR-V has no exponential in f64.
        let exponential = list.replace("sqrt(q_squared)", "exp(q_squared)");
        assert_ne!(exponential, list);
        assert_eq!(check(&exponential).is_err(), precision == Precision::F64);
    }
    let mut missing: PassSource = a_choice(Precision::F32).step();
    missing.slots.push("domain/nowhere".to_owned());
    let error = missing.link().expect_err("no such file");
    assert!(error.to_string().contains("domain/nowhere.wgsl"));
}

/// Offsets of the members and the size, as naga lays the block out.
fn laid_out(layout: &BlockLayout, real: Real) -> (Vec<u32>, u32) {
    let source = format!("alias real = {};\n{}", real.name(), layout.declaration());
    let module: Module = naga::front::wgsl::parse_str(&source).expect("a struct");
    let found = module.types.iter().find_map(|(_, of)| match &of.inner {
        TypeInner::Struct { members, span, .. } => {
            Some((members.iter().map(|m| m.offset).collect(), *span))
        }
        _ => None,
    });
    found.expect("the struct is there")
}

#[test]
fn parameter_blocks_are_laid_out_as_the_shaders_read_them() {
    let odd = BlockLayout { name: "Odd", counts: &["one", "two", "three"], reals: &["four"] };
    let of_vectors = [&COMBINATION, &UPDATE, &PLACES, &ENTRIES];
    for layout in [&GRID, &CHUNK, &STEP_SIZE, &PART, &CHAIN, &odd].into_iter().chain(of_vectors) {
        for real in Real::ALL {
            let (offsets, size) = laid_out(layout, real);
            let counts = (0..layout.counts.len()).map(|i| 4 * i);
            let reals =
                (0..layout.reals.len()).map(|i| layout.reals_offset(real) + i * real.size());
            let expected: Vec<u32> = counts.chain(reals).map(|offset| offset as u32).collect();
            assert_eq!(offsets, expected, "{} in {}", layout.name, real.name());
            assert_eq!(size as usize, layout.size(real));
        }
    }
    // The odd block has a gap in f64 and none in f32, or this checks nothing.
    let gap = |real| odd.reals_offset(real) - 12;
    assert_eq!((gap(Real::F32), gap(Real::F64)), (0, 4));
    let bytes = odd.contents(Real::F64, [1, 2, 3], [4.0]);
    assert_eq!(bytes.len(), 24);
    assert_eq!(bytes[16..], 4.0_f64.to_ne_bytes());
}
