//! The `materials` section.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::{CaseError, nearest};
use super::number::{Evaluator, Number};
use crate::model::Material;
use crate::model::material::DEFAULT_DENSITY;

/// A material of constant properties: its `diffusivity` alone, or what heat needs, `conductivity`,
/// `density` and `heat_capacity`. With the latter, fluxes are in W/m2, sources in W/m3 and amounts in J.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
#[schemars(extend("oneOf" = [
    { "required": ["diffusivity"], "properties": { "conductivity": false, "heat_capacity": false } },
    { "required": ["conductivity", "density", "heat_capacity"], "properties": { "diffusivity": false } }
]))]
pub(super) struct MaterialSpec {
    /// Diffusivity, m2/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    diffusivity: Option<Number>,
    /// Conductivity, W/(m K).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    conductivity: Option<Number>,
    /// Density, kg/m3; 1000 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    density: Option<Number>,
    /// Heat capacity of a unit mass, J/(kg K).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    heat_capacity: Option<Number>,
}

impl MaterialSpec {
    /// Whether it has what heat needs.
    pub(super) fn is_thermal(&self) -> bool {
        self.diffusivity.is_none()
    }

    /// Writes down what is taken where nothing is given.
    pub(super) fn fill_in_defaults(&mut self) {
        self.density.get_or_insert(DEFAULT_DENSITY.into());
    }

    /// The material `name`.
    pub(super) fn resolve(&self, name: &str, evaluator: &Evaluator) -> Result<Material, CaseError> {
        let path = |key: &str| format!("materials.{name}.{key}");
        let positive = |key: &str, number: &Number| evaluator.positive(&path(key), number);
        let needed = |key: &str, number: &Option<Number>| match number {
            Some(number) => positive(key, number),
            None => Err(CaseError::MissingKey { path: path(key) }),
        };
        let Self { diffusivity, conductivity, density, heat_capacity } = self;
        if let Some(diffusivity) = diffusivity {
            let of_heat = [("conductivity", conductivity), ("heat_capacity", heat_capacity)];
            if let Some((key, _)) = of_heat.into_iter().find(|(_, number)| number.is_some()) {
                let reason =
                    "the material has a diffusivity; heat needs conductivity, density and \
                              heat_capacity instead"
                        .to_owned();
                return Err(CaseError::UnusedKey { path: path(key), reason });
            }
            let diffusivity = positive("diffusivity", diffusivity)?;
            let density = density.as_ref();
            let density = density.map_or(Ok(DEFAULT_DENSITY), |rho| positive("density", rho))?;
            return Ok(Material::diffusive(name, diffusivity, density));
        }
        if conductivity.is_none() && heat_capacity.is_none() {
            return Err(CaseError::MissingKey { path: path("diffusivity") });
        }
        let conductivity = needed("conductivity", conductivity)?;
        let density = needed("density", density)?;
        let capacity = density * needed("heat_capacity", heat_capacity)?;
        Ok(Material { name: name.to_owned(), conductivity, capacity, density })
    }
}

/// The material of this name.
pub(super) fn material_by_name<'a>(
    path: &str,
    name: &str,
    materials: &'a [Material],
) -> Result<&'a Material, CaseError> {
    materials.iter().find(|material| material.name == name).ok_or_else(|| {
        let known: Vec<String> = materials.iter().map(|material| material.name.clone()).collect();
        let nearest = nearest(name, &known, 1);
        CaseError::UnknownName { path: path.to_owned(), text: name.to_owned(), nearest, known }
    })
}
