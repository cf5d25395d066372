//! The `exact` section: an analytic solution whose parameters default to what the scene says.

mod bodies;
mod heating;
mod layers;
mod melting;
mod setting;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::CaseError;
use super::number::{Field, Number, Point};
use crate::exact::{MassesInBox, PointSource, PointSourceInBox, Solution};

use bodies::{
    AnnulusSpec, ContactSpec, HalfSpaceSpec, OscillatingSlabSpec, QuenchedBoxSpec, SlabSpec,
    SphereSpec,
};
use heating::{ContinuousPointSourceSpec, HeatedSlabSpec};
use layers::LayersSpec;
use melting::{NeumannSpec, StefanSpec};
pub(super) use setting::Setting;

/// An analytic solution by name. What the scene determines may be left out: the diffusivity of the
/// only material, the domain, the only deposit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "name", deny_unknown_fields, rename_all = "snake_case", expecting = "an object")]
pub(super) enum ExactSpec {
    /// The same value everywhere.
    Uniform { value: Number },
    /// offset + gradient . x
    Affine { offset: Number, gradient: Point },
    /// A point source in free space.
    PointSource {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        amount: Option<Number>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        at: Option<Point>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        diffusivity: Option<Number>,
        /// Share of the volume that takes up the substance; 1 where absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        porosity: Option<Number>,
    },
    /// A point source in a box that nothing leaves.
    PointSourceInBox {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        amount: Option<Number>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        at: Option<Point>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        min: Option<Point>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        max: Option<Point>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        diffusivity: Option<Number>,
        /// Share of the volume that takes up the substance; 1 where absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        porosity: Option<Number>,
    },
    /// Equal point masses at the corners of a cube around `at`, in a box that nothing leaves: a
    /// deposit on 2^dim particles.
    MassesInBox {
        /// All masses together.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        amount: Option<Number>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        at: Option<Point>,
        /// Edge of the cube, m; the spacing where absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        separation: Option<Number>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        min: Option<Point>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        max: Option<Point>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        diffusivity: Option<Number>,
    },
    /// A slab between two plane faces, from a uniform initial value.
    Slab(SlabSpec),
    /// A body without end on the far side of a plane surface, from a uniform initial value.
    HalfSpace(HalfSpaceSpec),
    /// A solid sphere, from a uniform initial value.
    Sphere(SphereSpec),
    /// What lies between two concentric circles that are held, from a uniform initial value.
    Annulus(AnnulusSpec),
    /// A box from a uniform initial value, whose faces are held at one value.
    QuenchedBox(QuenchedBoxSpec),
    /// Two bodies that touch, each from a uniform initial value.
    Contact(ContactSpec),
    /// A slab whose left face swings, from a uniform initial value.
    OscillatingSlab(OscillatingSlabSpec),
    /// A source of constant power at a point of free space, into a uniform initial value.
    ContinuousPointSource(ContinuousPointSourceSpec),
    /// A slab with a uniform source between two held plane faces, from a uniform initial value.
    HeatedSlab(HeatedSlabSpec),
    /// The steady state of layers between two held plane faces.
    Layers(LayersSpec),
    /// A half space that melts or freezes from its held surface on, from a uniform temperature.
    Neumann(NeumannSpec),
    /// A half space that melts or freezes from its held surface on, from the melting temperature.
    Stefan(StefanSpec),
    /// An expression of x y z t.
    Expression { value: Number },
}

/// The solution, and its expression where it is one (to be checked where particles are).
pub(super) fn resolve(
    spec: &ExactSpec,
    setting: &Setting,
) -> Result<(Solution, Option<Field>), CaseError> {
    let dimension = setting.evaluator.dimension;
    let solution = match spec {
        ExactSpec::Uniform { value } => Solution::Uniform { value: setting.given("value", value)? },
        ExactSpec::Affine { offset, gradient } => Solution::Affine {
            offset: setting.given("offset", offset)?,
            gradient: setting.evaluator.point("exact.gradient", gradient)?,
        },
        ExactSpec::PointSource { amount, at, diffusivity, porosity } => {
            let (amount, at) = setting.deposit(amount, at)?;
            let porosity = setting.porosity(porosity)?;
            let diffusivity = setting.diffusivity(diffusivity)?;
            Solution::PointSource(PointSource { dimension, amount, at, diffusivity, porosity })
        }
        ExactSpec::PointSourceInBox { amount, at, min, max, diffusivity, porosity } => {
            let (amount, at) = setting.deposit(amount, at)?;
            let porosity = setting.porosity(porosity)?;
            let walls = setting.walls(min, max, diffusivity)?;
            Solution::PointSourceInBox(PointSourceInBox { walls, amount, at, porosity })
        }
        ExactSpec::MassesInBox { amount, at, separation, min, max, diffusivity } => {
            let (amount, at) = setting.deposit(amount, at)?;
            let separation = setting.positive_or("separation", separation, setting.spacing)?;
            let walls = setting.walls(min, max, diffusivity)?;
            Solution::MassesInBox(MassesInBox { walls, amount, at, separation })
        }
        ExactSpec::Slab(spec) => Solution::Slab(spec.resolve(setting)?),
        ExactSpec::HalfSpace(spec) => Solution::HalfSpace(spec.resolve(setting)?),
        ExactSpec::Sphere(spec) => Solution::Sphere(spec.resolve(setting)?),
        ExactSpec::Annulus(spec) => Solution::Annulus(spec.resolve(setting)?),
        ExactSpec::QuenchedBox(spec) => Solution::QuenchedBox(spec.resolve(setting)?),
        ExactSpec::Contact(spec) => Solution::Contact(spec.resolve(setting)?),
        ExactSpec::OscillatingSlab(spec) => Solution::OscillatingSlab(spec.resolve(setting)?),
        ExactSpec::ContinuousPointSource(spec) => {
            Solution::ContinuousPointSource(spec.resolve(setting)?)
        }
        ExactSpec::HeatedSlab(spec) => Solution::HeatedSlab(spec.resolve(setting)?),
        ExactSpec::Layers(spec) => Solution::Layers(spec.resolve(setting)?),
        ExactSpec::Neumann(spec) => Solution::Neumann(spec.resolve(setting)?),
        ExactSpec::Stefan(spec) => Solution::Neumann(spec.resolve(setting)?),
        ExactSpec::Expression { value } => {
            let field = setting.evaluator.field_in_time("exact.value", value)?;
            return Ok((Solution::Expression(field.scalar.clone()), Some(field)));
        }
    };
    Ok((solution, None))
}
