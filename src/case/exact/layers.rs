//! Layers in a steady state: specs, and how the scene fills in what they leave out.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::bodies::held_value;
use super::setting::Setting;
use crate::case::error::CaseError;
use crate::case::material::material_by_name;
use crate::case::number::{Number, in_range};
use crate::case::schema::Axis;
use crate::exact::{Layer, Layers, LayersSetup};
use crate::model::Face;

/// The steady state of layers between two held plane faces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct LayersSpec {
    axis: Axis,
    /// Coordinate of the left face, m; the domain's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    from: Option<Number>,
    /// Value of the left face; that of its wall where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    left: Option<Number>,
    /// Value of the right face; that of its wall where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    right: Option<Number>,
    /// From the left to the right.
    #[schemars(length(min = 1))]
    layers: Vec<LayerSpec>,
}

/// One of several layers, with a `material` or a `conductivity`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
#[schemars(extend("oneOf" = [{ "required": ["material"] }, { "required": ["conductivity"] }]))]
struct LayerSpec {
    /// Name of a material.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    material: Option<String>,
    /// W/(m K)
    #[serde(default, skip_serializing_if = "Option::is_none")]
    conductivity: Option<Number>,
    /// Coordinate of its right face, m; of the last layer the domain's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    to: Option<Number>,
    /// Contact resistance between it and the next layer, m2 K/W; 0 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    resistance: Option<Number>,
}

impl LayersSpec {
    pub(super) fn resolve(&self, setting: &Setting<'_>) -> Result<Layers, CaseError> {
        let axis = setting.axis(self.axis)?;
        let from = setting.number_or("from", &self.from, setting.domain.min[axis])?;
        let held = |key, value, upper| held_value(setting, key, value, Face { axis, upper });
        if self.layers.is_empty() {
            return Err(CaseError::MissingKey { path: "exact.layers[0]".to_owned() });
        }
        let mut layers = Vec::new();
        let mut lower = from;
        for (index, spec) in self.layers.iter().enumerate() {
            let key = format!("layers[{index}]");
            let end = (index + 1 == self.layers.len()).then(|| setting.domain.max[axis]);
            let layer = spec.resolve(setting, &key, end)?;
            let path = format!("exact.{key}.to");
            in_range(&path, layer.to, layer.to > lower, "above where the layer begins")?;
            lower = layer.to;
            layers.push(layer);
        }
        let (left, right) = (held("left", &self.left, false)?, held("right", &self.right, true)?);
        Ok(Layers::new(LayersSetup { axis, from, left, right, layers }))
    }
}

impl LayerSpec {
    /// The layer; `end` (m) is that of the domain, for the last one.
    fn resolve(
        &self,
        setting: &Setting<'_>,
        key: &str,
        end: Option<f64>,
    ) -> Result<Layer, CaseError> {
        let path = |part: &str| format!("exact.{key}.{part}");
        let conductivity = match (&self.material, &self.conductivity) {
            (Some(name), None) => {
                material_by_name(&path("material"), name, setting.materials)?.conductivity
            }
            (None, Some(number)) => setting.evaluator.positive(&path("conductivity"), number)?,
            (None, None) => return Err(CaseError::MissingKey { path: path("material") }),
            (Some(_), Some(_)) => {
                let reason = "the layer has a material already".to_owned();
                return Err(CaseError::UnusedKey { path: path("conductivity"), reason });
            }
        };
        let to = match (&self.to, end) {
            (Some(to), _) => setting.given(&format!("{key}.to"), to)?,
            (None, Some(end)) => end,
            (None, None) => return Err(CaseError::MissingKey { path: path("to") }),
        };
        let resistance = match &self.resistance {
            Some(_) if end.is_some() => {
                let reason = "no layer follows".to_owned();
                return Err(CaseError::UnusedKey { path: path("resistance"), reason });
            }
            Some(number) => setting.evaluator.not_negative(&path("resistance"), number)?,
            None => 0.0,
        };
        Ok(Layer { to, conductivity, resistance })
    }
}
