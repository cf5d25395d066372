//! What can be wrong with a case.

use std::path::PathBuf;

use super::wall::WallError;

/// What is wrong with a case, in one line that names the JSON path.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    /// Neither a file nor a shipped case.
    #[error("{text}: no such file or shipped case{}", did_you_mean(.nearest))]
    NotFound {
        /// What was asked for.
        text: String,
        /// Shipped names that look like it, best first.
        nearest: Vec<String>,
    },
    /// The file cannot be read.
    #[error("{}: {source}", .file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The text is not strict JSON.
    #[error("{}not valid JSON: {reason}", at(.path))]
    Json {
        /// Path of the value where reading stopped; empty at the top.
        path: String,
        /// What the parser says, with line and column.
        reason: String,
    },
    /// An override is not of the form `path=value`.
    #[error("\"{text}\": an override is written path.to.key=value")]
    OverrideSyntax {
        /// The text as given.
        text: String,
    },
    /// An override goes through a value that has no such part.
    #[error("{path}: cannot be set: {reason}")]
    OverridePath {
        /// The override's path.
        path: String,
        /// Why.
        reason: String,
    },
    /// A key that the format does not have.
    #[error("{path}: unknown key{} (known: {})", did_you_mean(.nearest), .known.join(", "))]
    UnknownKey {
        /// The key's path.
        path: String,
        /// The known key that looks most like it.
        nearest: Vec<String>,
        /// The keys that this object may have.
        known: Vec<String>,
    },
    /// A key that must be there is not.
    #[error("{path}: missing key")]
    MissingKey {
        /// The key's path.
        path: String,
    },
    /// A key that nothing in the case uses.
    #[error("{path}: not used: {reason}")]
    UnusedKey {
        /// The key's path.
        path: String,
        /// Why nothing uses it.
        reason: String,
    },
    /// A value of the wrong JSON type.
    #[error("{path}: {reason}")]
    WrongType {
        /// The value's path.
        path: String,
        /// What was expected and what was found.
        reason: String,
    },
    /// A name that stands for nothing.
    #[error(
        "{path}: unknown name \"{text}\"{} (known: {})",
        did_you_mean(.nearest), .known.join(", "))]
    UnknownName {
        /// The value's path.
        path: String,
        /// The name as given.
        text: String,
        /// The known name that looks most like it.
        nearest: Vec<String>,
        /// The names that may stand here.
        known: Vec<String>,
    },
    /// An expression that cannot be used here.
    #[error("{path}: \"{text}\": {reason} (allowed: {allowed})")]
    Expression {
        /// The expression's path.
        path: String,
        /// Its text.
        text: String,
        /// What is wrong with it.
        reason: String,
        /// The names that it may use.
        allowed: String,
    },
    /// A number outside its range.
    #[error("{path}: is {value}, must be {requirement}")]
    Range {
        /// The number's path.
        path: String,
        /// The number.
        value: f64,
        /// What it must be.
        requirement: String,
    },
    /// Something that does not go together with properties that depend on temperature.
    #[error("{path}: {reason}")]
    Thermal {
        /// The path of what does not.
        path: String,
        /// Why.
        reason: String,
    },
    /// A point or vector of the wrong length.
    #[error("{path}: has {found} components, must have {dimension} (the case's dimension)")]
    Components {
        /// The point's path.
        path: String,
        /// How many it has.
        found: usize,
        /// How many it must have.
        dimension: usize,
    },
    /// A shape that does not exist in this dimension, or whose parts contradict each other.
    #[error("{path}: {reason}")]
    Shape {
        /// The shape's path.
        path: String,
        /// What is wrong.
        reason: String,
    },
    /// A fill without bounds.
    #[error("{path}: has no bounds and cannot be filled; cut it out of a bounded shape")]
    Unbounded {
        /// The shape's path.
        path: String,
    },
    /// A fill without particles.
    #[error("{path}: holds no particle at spacing {spacing} m")]
    EmptyFill {
        /// The fill's path.
        path: String,
        /// Spacing, m.
        spacing: f64,
    },
    /// Two fills that share a lattice site.
    #[error("{second}: overlaps {first}: both contain the lattice site at {point}")]
    Overlap {
        /// The earlier fill's path.
        first: String,
        /// The later fill's path.
        second: String,
        /// A site of both.
        point: String,
    },
    /// More particles than an index can name.
    #[error("particles: {count:.0} particles, at most {limit} (they would take {gib:.0} GiB)")]
    TooManyParticles {
        /// How many there would be.
        count: f64,
        /// How many there may be.
        limit: u32,
        /// What they would take, GiB.
        gib: f64,
    },
    /// Memory that the system does not give.
    #[error("{path}: no memory for {count} particles ({bytes:.0} bytes)")]
    OutOfMemory {
        /// The fill's path.
        path: String,
        /// How many particles the fill has.
        count: usize,
        /// What they would take, bytes.
        bytes: f64,
    },
    /// A selection without particles.
    #[error("{path}: selects no particle")]
    NothingSelected {
        /// The selection's path.
        path: String,
    },
    /// Two entries that hold the same particle.
    #[error("{second}: holds the particle at {point}, which {first} holds already")]
    HeldTwice {
        /// The earlier entry's path.
        first: String,
        /// The later entry's path.
        second: String,
        /// The particle's position.
        point: String,
    },
    /// A periodic axis whose length is not a whole number of spacings.
    #[error(
        "{path}: {spacing} m does not divide the periodic axis {axis} of {extent} m; {fits} m does"
    )]
    NotWhole {
        /// Path of the spacing.
        path: String,
        /// Spacing, m.
        spacing: f64,
        /// Name of the axis.
        axis: &'static str,
        /// Length of the axis, m.
        extent: f64,
        /// The nearest spacing that fits, m.
        fits: f64,
    },
    /// A support wider than half a periodic axis.
    #[error(
        "{path}: the support radius of {support_radius} m is more than half of the periodic axis \
         {axis} of {extent} m; {}", widest(*.most)
    )]
    SupportTooWide {
        /// Path of the support ratio.
        path: String,
        /// Support radius, m.
        support_radius: f64,
        /// The largest support ratio that fits the axis; at 1 and below none does.
        most: f64,
        /// Name of the axis.
        axis: &'static str,
        /// Length of the axis, m.
        extent: f64,
    },
    /// A kernel that is not defined in the case's dimension.
    #[error("{path}: {kernel} is not defined in {dimension} dimensions")]
    KernelDimension {
        /// Path of the kernel's name.
        path: String,
        /// The kernel's name.
        kernel: &'static str,
        /// The case's dimension.
        dimension: usize,
    },
    /// A name or a thing that is given twice.
    #[error("{path}: \"{text}\" is given twice")]
    Duplicate {
        /// Path of the second.
        path: String,
        /// What is given twice.
        text: String,
    },
    /// A point outside the domain.
    #[error("{path}: {point} lies outside the domain, {min} to {max}")]
    OutsideDomain {
        /// The point's path.
        path: String,
        /// The point.
        point: String,
        /// Lower corner of the domain.
        min: String,
        /// Upper corner of the domain.
        max: String,
    },
    /// A parameter that the scene does not determine.
    #[error("{path}: missing key: {reason}")]
    Undetermined {
        /// The parameter's path.
        path: String,
        /// Why the scene does not give it.
        reason: String,
    },
    /// A point source that no particle is near.
    #[error(
        "{path}: no particle within the support radius that is not held: the source is outside of the body"
    )]
    SourceInVoid {
        /// The path of the point or points.
        path: String,
    },
    /// A named solution of a scene with sources, which it does not know.
    #[error("exact: the solution {name} knows no sources; compare with an expression")]
    ExactWithoutSources {
        /// The solution's name.
        name: &'static str,
    },
    /// A wall or a surface that does not fit.
    #[error(transparent)]
    Wall(#[from] WallError),
}

fn at(path: &str) -> String {
    if path.is_empty() { String::new() } else { format!("{path}: ") }
}

fn widest(most: f64) -> String {
    if most > 1.0 {
        return format!("the largest support_ratio allowed is {most}");
    }
    "no support_ratio fits an axis of at most 2 spacings".to_owned()
}

fn did_you_mean(nearest: &[String]) -> String {
    if nearest.is_empty() {
        return String::new();
    }
    let quoted: Vec<String> = nearest.iter().map(|name| format!("\"{name}\"")).collect();
    format!("; did you mean {}?", quoted.join(" or "))
}

/// The `known` names that look like `text`, best first, at most `count`.
pub(super) fn nearest<S: AsRef<str>>(text: &str, known: &[S], count: usize) -> Vec<String> {
    /// Below this similarity (0 to 1) a suggestion would confuse.
    const SIMILAR: f64 = 0.72;
    // One slip is similar in the shortest of names too, where the measure is not of much use.
    let similarity = |name: &str| match strsim::osa_distance(text, name) {
        0 | 1 => 1.0,
        _ => strsim::jaro_winkler(text, name),
    };
    let mut scored: Vec<(f64, &str)> = known
        .iter()
        .map(|name| (similarity(name.as_ref()), name.as_ref()))
        .filter(|(score, _)| *score >= SIMILAR)
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.into_iter().take(count).map(|(_, name)| name.to_owned()).collect()
}
