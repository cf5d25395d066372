//! Solutions with sources: specs, and how the scene fills in what they leave out.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::bodies::{extent, held_value};
use super::setting::Setting;
use crate::case::error::CaseError;
use crate::case::number::{Number, Point};
use crate::case::schema::Axis;
use crate::case::source::SourceSpec;
use crate::exact::{ContinuousPointSource, HeatedSlab, HeatedSlabSetup};
use crate::model::Face;

/// The source that a [`ContinuousPointSourceSpec`] takes its parameters from.
const LASTING: &str = "a constant power at a point";

/// The source that a [`HeatedSlabSpec`] takes its parameters from.
const UNIFORM: &str = "a constant rate everywhere";

/// A source of constant power at a point of free space from t = 0 on, into a uniform initial value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct ContinuousPointSourceSpec {
    /// W, or value x volume/s where there is a diffusivity alone, in 1-D of a unit area, in 2-D of a
    /// unit length; that of the only source where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    power: Option<Number>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    at: Option<Point>,
    initial: Number,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    diffusivity: Option<Number>,
}

/// A slab with a uniform source between two held plane faces, from a uniform initial value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct HeatedSlabSpec {
    axis: Axis,
    /// Coordinate of the left face, m; the domain's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    from: Option<Number>,
    /// Coordinate of the right face, m; the domain's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    to: Option<Number>,
    /// Value of the left face; that of its wall where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    left: Option<Number>,
    /// Value of the right face; that of its wall where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    right: Option<Number>,
    initial: Number,
    /// W/m3, or value/s where there is a diffusivity alone; that of the only source where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    rate: Option<Number>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    diffusivity: Option<Number>,
}

impl ContinuousPointSourceSpec {
    pub(super) fn resolve(
        &self,
        setting: &Setting<'_>,
    ) -> Result<ContinuousPointSource, CaseError> {
        let power = match &self.power {
            Some(power) => setting.given("power", power)?,
            None => setting.only_source("power", LASTING, SourceSpec::constant_power)?,
        };
        let at = match &self.at {
            Some(at) => setting.evaluator.point("exact.at", at)?,
            None => setting.only_source("at", LASTING, SourceSpec::point)?,
        };
        Ok(ContinuousPointSource {
            dimension: setting.evaluator.dimension,
            power: power / setting.capacity()?,
            at,
            initial: setting.given("initial", &self.initial)?,
            diffusivity: setting.diffusivity(&self.diffusivity)?,
        })
    }
}

impl HeatedSlabSpec {
    pub(super) fn resolve(&self, setting: &Setting<'_>) -> Result<HeatedSlab, CaseError> {
        let axis = setting.axis(self.axis)?;
        let (from, to) = extent(setting, axis, &self.from, &self.to)?;
        let held = |key, value, upper| held_value(setting, key, value, Face { axis, upper });
        let rate = match &self.rate {
            Some(rate) => setting.given("rate", rate)?,
            None => setting.only_source("rate", UNIFORM, SourceSpec::constant_rate)?,
        };
        Ok(HeatedSlab::new(HeatedSlabSetup {
            axis,
            from,
            to,
            left: held("left", &self.left, false)?,
            right: held("right", &self.right, true)?,
            initial: setting.given("initial", &self.initial)?,
            rate: rate / setting.capacity()?,
            diffusivity: setting.diffusivity(&self.diffusivity)?,
        }))
    }
}
