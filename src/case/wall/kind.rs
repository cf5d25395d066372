//! What a wall does, as a case file says it.

use glam::DVec3;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::WallError;
use crate::case::error::CaseError;
use crate::case::number::{Evaluator, Field, Number, in_range, show};
use crate::model::{Condition, WallKind};

/// What a wall does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case", expecting = "a kind of wall")]
pub(in crate::case) enum WallKindSpec {
    /// The support is truncated, so that nothing crosses.
    Free,
    /// Nothing crosses.
    Insulated,
    /// The value at the wall, which may depend on x y z t.
    Value(Number),
    /// The flux into the body, value x m/s or W/m2, which may depend on x y z t.
    Flux(Number),
    /// The flux coefficient x (ambient - value at the wall) into the body.
    Convection(ConvectionSpec),
}

/// Exchange with an ambient.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct ConvectionSpec {
    /// Transfer coefficient, m/s or W/(m2 K), zero or positive, which may depend on x y z.
    pub(in crate::case) coefficient: Number,
    /// Value of the ambient, which may depend on x y z t.
    pub(in crate::case) ambient: Number,
}

/// A condition, with where its numbers came from.
pub(super) struct Kind {
    pub(super) condition: Condition,
    imposed: Option<Field>,
    coefficient: Option<Field>,
    dimension: usize,
}

impl WallKindSpec {
    /// The kind without its numbers.
    pub(in crate::case) fn kind(&self) -> WallKind {
        match self {
            Self::Free => WallKind::Free,
            Self::Insulated => WallKind::Insulated,
            Self::Value(_) => WallKind::Value,
            Self::Flux(_) => WallKind::Flux,
            Self::Convection(_) => WallKind::Convection,
        }
    }

    /// Evaluates the numbers; what depends on position is checked by [`Kind::check`].
    pub(super) fn resolve(&self, evaluator: &Evaluator, path: &str) -> Result<Kind, CaseError> {
        let imposed =
            |key: &str, number: &Number| evaluator.field_in_time(&format!("{path}.{key}"), number);
        let dimension = evaluator.dimension;
        let bare = |condition| Kind { condition, imposed: None, coefficient: None, dimension };
        let imposing = |condition: fn(_) -> Condition, field: Field| {
            let bare = bare(condition(field.scalar.clone()));
            Kind { imposed: Some(field), ..bare }
        };
        Ok(match self {
            Self::Free => bare(Condition::free()),
            Self::Insulated => bare(Condition::insulated()),
            Self::Value(value) => imposing(Condition::value, imposed("value", value)?),
            Self::Flux(flux) => imposing(Condition::flux, imposed("flux", flux)?),
            Self::Convection(ConvectionSpec { coefficient, ambient }) => {
                let key = format!("{path}.convection.coefficient");
                let coefficient = evaluator.field(&key, coefficient)?;
                if let Some(value) = coefficient.constant {
                    in_range(&key, value, value >= 0.0, "zero or positive")?;
                }
                let ambient = imposed("convection.ambient", ambient)?;
                let condition =
                    Condition::convection(coefficient.scalar.clone(), ambient.scalar.clone());
                let (imposed, coefficient) = (Some(ambient), Some(coefficient));
                Kind { condition, imposed, coefficient, dimension }
            }
        })
    }
}

impl Kind {
    /// Refuses numbers that are no good at `x` (m): not finite at t = 0, or a coefficient below
    /// zero.
    pub(super) fn check(&self, x: DVec3) -> Result<(), CaseError> {
        if let Some(imposed) = &self.imposed {
            imposed.at(x, 0.0)?;
        }
        let Some(coefficient) = &self.coefficient else {
            return Ok(());
        };
        let value = coefficient.at(x, 0.0)?;
        if value >= 0.0 {
            return Ok(());
        }
        let (path, point) = (coefficient.path().to_owned(), show(x, self.dimension));
        Err(WallError::NegativeCoefficient { path, value, point }.into())
    }
}

/// The kinds that a surface can be.
pub(super) fn surface_kinds(generator: &mut SchemaGenerator) -> Schema {
    let of_one_key = |key: &str, value: Schema| {
        json_schema!({
            "type": "object",
            "properties": { key: value },
            "required": [key],
            "additionalProperties": false
        })
    };
    json_schema!({
        "description": "A flux into the body, value x m/s or W/m2, or exchange with an ambient.",
        "oneOf": [
            of_one_key("flux", generator.subschema_for::<Number>()),
            of_one_key("convection", generator.subschema_for::<ConvectionSpec>())
        ]
    })
}
