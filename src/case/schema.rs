//! The types of the case file: read, written back as resolved, and described by a JSON Schema.
//!
//! Numbers and points stay as written here; [`super::build`] evaluates and checks them.

use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::OutputField;
use super::exact::ExactSpec;
use super::material::MaterialSpec;
use super::number::{Number, Point};
use super::shape::ShapeSpec;
use super::source::SourceSpec;
use super::wall::{SurfaceSpec, WallSpec};
use crate::model::integrator::{Method, MethodChoice, Preconditioner};
use crate::model::{Correction, KernelKind, PairMean};

/// A scene for diffusph. SI units throughout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
#[schemars(title = "diffusph case")]
pub(super) struct Case {
    /// Where this schema lies, for editors.
    #[serde(rename = "$schema", default, skip_serializing)]
    pub(super) schema: Option<String>,
    /// One line on what the case shows.
    pub(super) title: String,
    /// 1, 2 or 3; points have as many components.
    #[schemars(range(min = 1, max = 3))]
    pub(super) dimension: u32,
    pub(super) particles: ParticlesSpec,
    pub(super) kernel: KernelSpec,
    #[serde(default)]
    pub(super) operator: OperatorSpec,
    /// What the fills are made of, by name.
    pub(super) materials: BTreeMap<String, MaterialSpec>,
    /// What resists where two materials meet.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) contacts: Vec<ContactSpec>,
    /// Values at t = 0, which are 0 where no entry says otherwise.
    #[serde(default)]
    pub(super) initial: Vec<InitialSpec>,
    /// Held particles, periodic axes, walls and surfaces. Faces that are not listed are free.
    #[serde(default)]
    pub(super) boundaries: Vec<BoundarySpec>,
    /// What particles get beside what flows between them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) sources: Vec<SourceSpec>,
    pub(super) time: TimeSpec,
    /// What the result is compared with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) exact: Option<ExactSpec>,
    /// Where the value is recorded over time.
    #[serde(default)]
    pub(super) probes: Vec<ProbeSpec>,
    #[serde(default)]
    pub(super) output: OutputSpec,
}

/// A resistance where two materials meet: between them the value jumps by it times what flows through a unit
/// of area.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(super) struct ContactSpec {
    /// Names of two materials.
    #[schemars(length(min = 2, max = 2))]
    pub(super) between: Vec<String>,
    /// m2 K/W; with a diffusivity alone s/m.
    pub(super) resistance: Number,
}

/// The particles: shapes filled with a lattice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(super) struct ParticlesSpec {
    /// Distance between neighbours, m.
    pub(super) spacing: Number,
    #[serde(default)]
    pub(super) arrangement: Arrangement,
    /// Shapes without overlap; the domain is the box around them all.
    #[schemars(length(min = 1))]
    pub(super) fill: Vec<FillSpec>,
}

/// How particles are arranged: `lattice` puts them at the centres of square cells that start at
/// the lower corner of the first fill.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Arrangement {
    #[default]
    Lattice,
}

/// A shape filled with particles of one material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(super) struct FillSpec {
    pub(super) shape: ShapeSpec,
    /// Name of a material.
    pub(super) material: String,
}

/// The smoothing kernel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(super) struct KernelSpec {
    #[schemars(schema_with = "kernel_names")]
    pub(super) name: String,
    /// Support radius over spacing, above 1 and at most 50.
    pub(super) support_ratio: Number,
}

/// The diffusion operator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "an object")]
pub(super) struct OperatorSpec {
    /// How the diffusivities of a pair are joined.
    #[schemars(schema_with = "pair_mean_names")]
    pub(super) pair_mean: String,
    /// `moment` divides by the lattice's effective diffusivity; `none` is the plain operator.
    #[schemars(schema_with = "correction_names")]
    pub(super) correction: String,
}

impl Default for OperatorSpec {
    fn default() -> Self {
        Self {
            pair_mean: PairMean::Harmonic.name().to_owned(),
            correction: Correction::Moment.name().to_owned(),
        }
    }
}

/// Either `value` (which may depend on x y z), everywhere or in a shape, where a later entry
/// replaces an earlier one; or `amount`, a total of value x volume, or an energy in J, that raises the values of
/// the particles nearest to `at`, in equal parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
#[schemars(extend("oneOf" = [
    { "required": ["value"], "properties": { "amount": false, "at": false } },
    { "required": ["amount", "at"], "properties": { "value": false, "where": false } }
]))]
pub(super) struct InitialSpec {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) value: Option<Number>,
    #[serde(default, rename = "where", skip_serializing_if = "Option::is_none")]
    pub(super) selection: Option<ShapeSpec>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) amount: Option<Number>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) at: Option<Point>,
}

/// What happens at the edge, or wherever particles are held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case", expecting = "an object of one key")]
pub(super) enum BoundarySpec {
    /// Particles whose value does not change.
    Held {
        #[serde(rename = "where")]
        selection: Box<ShapeSpec>,
        /// The value, which may depend on x y z.
        value: Number,
    },
    /// Axes on which the domain repeats.
    Periodic { axes: Vec<Axis> },
    /// A wall on a face of the domain.
    Wall(WallSpec),
    /// A surface of the body that is no face of the domain.
    Surface(SurfaceSpec),
}

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Axis {
    X,
    Y,
    Z,
}

/// Duration, step and method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(super) struct TimeSpec {
    /// Simulated time, s; 0 writes the initial state alone.
    pub(super) end: Number,
    /// Step, s. Where neither it nor a tolerance is given, euler takes the largest that is known to be
    /// stable, and other methods follow a tolerance of 1e-4 of the largest value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) step: Option<Number>,
    /// What the steps may leave as an error of the result, in place of a step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) tolerance: Option<ToleranceSpec>,
    /// The time integrator: auto takes the cheapest that follows the tolerance, or where something melts
    /// euler; steady goes straight to the steady state.
    #[serde(default = "default_method")]
    #[schemars(schema_with = "method_names")]
    pub(super) method: String,
    /// Times at which something that is imposed changes at once, s: a step ends there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) breaks: Vec<Number>,
    /// How well linear systems are solved: with tr_bdf2 and a given step, of the largest value (1e-6
    /// where absent); with steady, of the first residual (1e-10).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) linear_tolerance: Option<Number>,
    /// What linear systems are preconditioned by: two_level, where absent, or jacobi.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "preconditioner_names")]
    pub(super) preconditioner: Option<String>,
}

/// What the result may be off: `absolute` + `relative` x the largest magnitude of the field.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "an object")]
pub(super) struct ToleranceSpec {
    /// In the unit of the field; 0 where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) absolute: Option<Number>,
    /// Of the largest magnitude of the field; 0 where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) relative: Option<Number>,
}

/// A place where the value is recorded over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(super) struct ProbeSpec {
    pub(super) name: String,
    pub(super) at: Point,
}

/// What is written, and when.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "an object")]
pub(super) struct OutputSpec {
    /// Time between two outputs of the fields, s; the end where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) every: Option<Number>,
    /// Time between two records of the probes, s; `every` where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) probe_every: Option<Number>,
    /// Fields to write; the value, and with an exact solution that and the error, where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) fields: Option<Vec<OutputField>>,
}

/// The JSON Schema of a case file.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(Case).to_value()
}

fn default_method() -> String {
    Method::Euler.name().to_owned()
}

fn names<T: Copy>(all: &[T], name: impl Fn(T) -> &'static str) -> Schema {
    let names: Vec<&str> = all.iter().map(|&entry| name(entry)).collect();
    json_schema!({ "type": "string", "enum": names })
}

fn kernel_names(_: &mut SchemaGenerator) -> Schema {
    names(&KernelKind::ALL, KernelKind::name)
}

fn pair_mean_names(_: &mut SchemaGenerator) -> Schema {
    names(&PairMean::ALL, PairMean::name)
}

fn correction_names(_: &mut SchemaGenerator) -> Schema {
    names(&Correction::ALL, Correction::name)
}

fn preconditioner_names(_: &mut SchemaGenerator) -> Schema {
    names(&Preconditioner::ALL, Preconditioner::name)
}

fn method_names(_: &mut SchemaGenerator) -> Schema {
    names(&MethodChoice::all(), MethodChoice::name)
}
