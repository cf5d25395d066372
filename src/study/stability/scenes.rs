//! The extreme scenes: made here, the same on every machine.

use glam::DVec3;
use serde_json::{Value, json};

use crate::case;
use crate::model::stability::rough_field;
use crate::model::{Correction, KernelKind, Problem, ScalarField, Source};

/// Particles along an edge of a plate.
const EDGE: usize = 16;

/// The spacing, m: a plate is 1 m wide.
const SPACING: f64 = 0.0625;

/// Contrasts of diffusivity.
const CONTRASTS: [f64; 4] = [1.0, 1e3, 1e6, 1e9];

/// One in so many particles is isolated.
const RARE: usize = 32;

/// Jitter of particles, of the spacing.
const JITTERS: [f64; 4] = [0.1, 0.2, 0.3, 0.4];

/// Values and diffusivities that are far from 1.
const MAGNITUDES: [f64; 2] = [1e-30, 1e30];

/// A scene with what is asked of it.
#[derive(Clone, Debug)]
pub(super) struct ExtremeScene {
    /// Its name.
    pub(super) name: String,
    /// The group that it belongs to.
    pub(super) group: &'static str,
    /// What is solved.
    pub(super) problem: Problem,
    /// How long it runs.
    pub(super) length: Length,
}

/// How long a scene runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Length {
    /// So many safe steps, with steps that suit each method.
    Steps(u64),
    /// So many equal steps of the safe bound, whatever the method.
    EqualSteps(u64),
    /// So many safe steps; after half of them the first source, or where there is none the first wall's
    /// value, jumps from 0 to 1.
    Jump(u64),
}

impl Length {
    /// Safe steps.
    pub(super) fn steps(self) -> u64 {
        match self {
            Self::Steps(steps) | Self::EqualSteps(steps) | Self::Jump(steps) => steps,
        }
    }
}

/// Every scene, group by group.
pub(super) fn all() -> Vec<ExtremeScene> {
    let mut scenes = contrasts();
    scenes.extend(disorder());
    scenes.extend(shapes());
    scenes.extend(magnitudes());
    scenes.extend(times());
    scenes
}

fn scene(group: &'static str, name: impl Into<String>, problem: Problem) -> ExtremeScene {
    ExtremeScene { name: name.into(), group, problem, length: Length::Steps(200) }
}

/// What is at the edges of a body.
#[derive(Clone, Copy)]
enum Edges {
    /// Value 1 at the left, insulated elsewhere.
    Driven,
    /// Insulated all around.
    Closed,
    /// Truncated all around.
    Free,
    /// Periodic all around.
    Periodic,
}

/// A lattice of `counts` particles with rough values between 0 and 1 and D = 1 m2/s.
fn lattice(counts: &[usize], edges: Edges) -> Problem {
    body(KernelKind::CubicSpline, 2.0, Correction::Moment, counts, edges)
}

/// A lattice that is periodic all around.
pub(super) fn periodic(
    kernel: KernelKind,
    support_ratio: f64,
    correction: Correction,
    counts: &[usize],
) -> Problem {
    body(kernel, support_ratio, correction, counts, Edges::Periodic)
}

fn body(
    kernel: KernelKind,
    support_ratio: f64,
    correction: Correction,
    counts: &[usize],
    edges: Edges,
) -> Problem {
    let axes = &["x", "y", "z"][..counts.len()];
    let max: Vec<f64> = counts.iter().map(|count| *count as f64 * SPACING).collect();
    let min = vec![0.0; counts.len()];
    let faces: Vec<String> =
        axes.iter().flat_map(|axis| [format!("{axis}_min"), format!("{axis}_max")]).collect();
    let wall = |faces: &[String], kind: Value| json!({ "wall": { "faces": faces, "kind": kind } });
    let boundaries = match edges {
        Edges::Driven => {
            json!([wall(&faces[..1], json!({ "value": 1 })), wall(&faces[1..], json!("insulated"))])
        }
        Edges::Closed => json!([wall(&faces, json!("insulated"))]),
        Edges::Free => json!([]),
        Edges::Periodic => json!([{ "periodic": { "axes": axes } }]),
    };
    let case = json!({
        "title": "an extreme scene",
        "dimension": counts.len(),
        "particles": {
            "spacing": SPACING,
            "fill": [{ "shape": { "box": { "min": min, "max": max } }, "material": "unit" }]
        },
        "kernel": { "name": kernel.name(), "support_ratio": support_ratio },
        "operator": { "correction": correction.name() },
        "materials": { "unit": { "diffusivity": 1 } },
        "initial": [{ "value": 0 }],
        "boundaries": boundaries,
        "time": { "end": 1 }
    });
    let mut problem = case::from_json("extreme", case, &[]).expect("the scene is a case").problem;
    problem.initial = rough_field(problem.particles.len()).iter().map(|x| x + 0.5).collect();
    problem
}

/// Whether a particle is slow: by its index, its position (m) and a number between -0.5 and 0.5.
type IsSlow = fn(usize, DVec3, f64) -> bool;

/// Layers, random, isolated fast and isolated slow particles at every contrast.
fn contrasts() -> Vec<ExtremeScene> {
    let kinds: [(&str, IsSlow); 4] = [
        ("layers", |_, x, _| (x.x / (4.0 * SPACING)) as usize % 2 == 1),
        ("random", |_, _, noise| noise > 0.0),
        ("isolated fast", |particle, _, _| particle % RARE != RARE / 2 + particle / RARE % 4),
        ("isolated slow", |particle, _, _| particle % RARE == RARE / 2 + particle / RARE % 4),
    ];
    let mut scenes = Vec::new();
    for contrast in CONTRASTS {
        for (name, is_slow) in kinds {
            if contrast == 1.0 && !scenes.is_empty() {
                // Without a contrast they are all the same.
                continue;
            }
            let mut problem = lattice(&[EDGE, EDGE], Edges::Driven);
            let mut slow = problem.materials[0].clone();
            slow.name = "slow".to_owned();
            slow.conductivity /= contrast;
            problem.materials.push(slow);
            let noise = noise(problem.particles.len(), 2);
            let particles = &mut problem.particles;
            for (particle, material) in particles.material.iter_mut().enumerate() {
                let x = particles.position[particle];
                *material = u16::from(is_slow(particle, x, noise[particle]));
            }
            let name = match contrast == 1.0 {
                true => "one material".to_owned(),
                false => format!("{name} {contrast:e}"),
            };
            scenes.push(scene("contrast", name, problem));
        }
    }
    scenes
}

/// Jitter up to 40 %, and with a contrast.
fn disorder() -> Vec<ExtremeScene> {
    let jittered = |jitter: f64| {
        let mut problem = lattice(&[EDGE, EDGE], Edges::Driven);
        shake(&mut problem, jitter);
        problem
    };
    let percent = |jitter: f64| format!("jitter {} %", (100.0 * jitter).round());
    let mut scenes: Vec<ExtremeScene> = JITTERS
        .iter()
        .map(|&jitter| scene("disorder", percent(jitter), jittered(jitter)))
        .collect();
    let mut both = jittered(JITTERS[3]);
    let mut slow = both.materials[0].clone();
    slow.conductivity /= 1e9;
    both.materials.push(slow);
    let noise = noise(both.particles.len(), 2);
    let materials = both.particles.material.iter_mut().zip(noise);
    materials.for_each(|(material, noise)| *material = u16::from(noise > 0.0));
    scenes.push(scene("disorder", format!("{}, random 1e9", percent(JITTERS[3])), both));
    scenes
}

/// Moves every particle by up to `jitter` spacings along each axis.
fn shake(problem: &mut Problem, jitter: f64) {
    let axes = problem.dimension;
    let noise = noise(problem.particles.len() * axes, 3);
    for (x, noise) in problem.particles.position.iter_mut().zip(noise.chunks_exact(axes)) {
        for axis in 0..axes {
            x[axis] += 2.0 * jitter * SPACING * noise[axis];
        }
    }
}

/// Numbers between -0.5 and 0.5; other ones for each `seed`.
fn noise(count: usize, seed: usize) -> Vec<f64> {
    rough_field(count * seed).split_off(count * (seed - 1))
}

/// Bodies that are hardly bodies.
fn shapes() -> Vec<ExtremeScene> {
    let plate = |edges| lattice(&[EDGE, EDGE], edges);
    let mut coincident = plate(Edges::Driven);
    let position = &mut coincident.particles.position;
    position[100] = position[101];
    let mut lonely = plate(Edges::Free);
    lonely.domain.max.x += 1.0;
    lonely.particles.position[EDGE - 1].x += 1.0;
    let mut cracked = plate(Edges::Driven);
    keep(&mut cracked, |x| (x.x / SPACING) as usize != EDGE / 2);
    vec![
        scene("shape", "two particles at one point", coincident),
        scene("shape", "a particle without neighbours", lonely),
        scene("shape", "a crack one spacing wide", cracked),
        scene("shape", "a single particle", lattice(&[1, 1], Edges::Free)),
        scene("shape", "four particles between walls", lattice(&[2, 2], Edges::Driven)),
        scene("shape", "a sheet one particle thick", lattice(&[EDGE, EDGE, 1], Edges::Free)),
        scene("shape", "a cube", lattice(&[8, 8, 8], Edges::Driven)),
    ]
}

/// Leaves the particles whose position fits.
fn keep(problem: &mut Problem, fits: impl Fn(DVec3) -> bool) {
    let kept: Vec<bool> = problem.particles.position.iter().map(|x| fits(*x)).collect();
    fn filter<T>(values: &mut Vec<T>, kept: &[bool]) {
        let mut flags = kept.iter();
        values.retain(|_| flags.next().copied().unwrap_or(false));
    }
    filter(&mut problem.particles.position, &kept);
    filter(&mut problem.particles.volume, &kept);
    filter(&mut problem.particles.material, &kept);
    filter(&mut problem.initial, &kept);
}

/// Values and diffusivities from 1e-30 to 1e30.
fn magnitudes() -> Vec<ExtremeScene> {
    let plate = || lattice(&[EDGE, EDGE], Edges::Driven);
    let mut scenes = Vec::new();
    for scale in MAGNITUDES {
        let mut problem = plate();
        problem.initial.iter_mut().for_each(|value| *value *= scale);
        problem.walls[0].condition.imposed = ScalarField::constant(scale);
        scenes.push(scene("magnitude", format!("values of {scale:e}"), problem));
    }
    for diffusivity in MAGNITUDES {
        let mut problem = plate();
        problem.materials[0].conductivity = diffusivity;
        scenes.push(scene("magnitude", format!("D = {diffusivity:e} m2/s"), problem));
    }
    scenes
}

/// A wall that jumps, a source that starts, and a million steps.
fn times() -> Vec<ExtremeScene> {
    let jump = lattice(&[EDGE, EDGE], Edges::Driven);
    let mut fed = lattice(&[EDGE, EDGE], Edges::Driven);
    fed.sources = vec![Source {
        name: "source".to_owned(),
        particles: Some((0..fed.particles.len() as u32 / 2).collect()),
        rate: ScalarField::constant(0.0),
        linear: ScalarField::constant(-1.0),
    }];
    let long = lattice(&[8], Edges::Closed);
    vec![
        ExtremeScene { length: Length::Jump(200), ..scene("time", "a wall that jumps", jump) },
        ExtremeScene { length: Length::Jump(200), ..scene("time", "a source that starts", fed) },
        ExtremeScene { length: Length::EqualSteps(1_000_000), ..scene("time", "1e6 steps", long) },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_what_its_name_says() {
        let scenes = all();
        let mut names: Vec<&str> = scenes.iter().map(|scene| &*scene.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), scenes.len(), "every name is there once");
        let named = |name: &str| {
            let found = scenes.iter().find(|scene| scene.name == name);
            &found.unwrap_or_else(|| panic!("no {name}")).problem
        };
        let slow = |problem: &Problem| {
            problem.particles.material.iter().map(|&m| usize::from(m)).sum::<usize>()
        };
        assert_eq!(slow(named("layers 1e9")), 128);
        assert!((100..156).contains(&slow(named("random 1e3"))));
        assert_eq!(slow(named("isolated slow 1e6")), 8);
        assert_eq!(slow(named("isolated fast 1e6")), 256 - 8);
        assert_eq!(named("layers 1e9").materials[1].conductivity, 1e-9);
        assert_eq!(named("a crack one spacing wide").particles.len(), 240);
        assert_eq!(named("a single particle").particles.len(), 1);
        let largest = named("values of 1e30").initial.iter().copied().fold(0.0, f64::max);
        assert!((5e29..1e30).contains(&largest));
    }

    #[test]
    fn jitter_moves_as_far_as_it_says() {
        let scenes = all();
        let straight = lattice(&[EDGE, EDGE], Edges::Driven);
        for jitter in JITTERS {
            let name = format!("jitter {} %", (100.0 * jitter).round());
            let found = scenes.iter().find(|scene| scene.name == name).expect("it is there");
            let pairs = found.problem.particles.position.iter().zip(&straight.particles.position);
            let farthest = pairs.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max);
            let part = farthest / (jitter * SPACING);
            assert!((0.97..=1.0).contains(&part), "{jitter}: {part}");
        }
    }
}
