//! The `materials` section.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::error::{CaseError, nearest};
use super::number::{Evaluator, Number, OfTemperature, in_range};
use crate::model::material::{DEFAULT_DENSITY, straightened};
use crate::model::{Conductivity, Material, Melting};

/// A material: its `diffusivity` alone, or what heat needs, `conductivity`, `density` and
/// `heat_capacity`. With the latter, fluxes are in W/m2, sources in W/m3 and amounts in J. It melts where
/// it has a `melting_temperature` and a `latent_heat`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
#[schemars(extend("oneOf" = [
    { "required": ["diffusivity"], "properties": {
        "conductivity": false, "heat_capacity": false,
        "melting_temperature": false, "latent_heat": false, "liquid": false
    } },
    { "required": ["conductivity", "density", "heat_capacity"], "properties": { "diffusivity": false } }
], "dependentRequired" = {
    "melting_temperature": ["latent_heat"],
    "latent_heat": ["melting_temperature"],
    "liquid": ["melting_temperature"]
}))]
pub(super) struct MaterialSpec {
    /// Diffusivity, m2/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    diffusivity: Option<Number>,
    /// Conductivity, W/(m K).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    conductivity: Option<ConductivitySpec>,
    /// Density, kg/m3; 1000 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    density: Option<Number>,
    /// Heat capacity of a unit mass, J/(kg K).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    heat_capacity: Option<Number>,
    /// Temperature at which it melts, K, or those at which melting begins and ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    melting_temperature: Option<MeltingTemperature>,
    /// Heat that a unit mass takes up in melting, J/kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    latent_heat: Option<Number>,
    /// What differs once it has melted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    liquid: Option<LiquidSpec>,
}

/// Properties of a melt; those of the solid where absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(super) struct LiquidSpec {
    /// Conductivity, W/(m K).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    conductivity: Option<ConductivitySpec>,
    /// Density, kg/m3: it counts in the heat that the liquid takes up; particles keep their volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    density: Option<Number>,
    /// Heat capacity of a unit mass, J/(kg K).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    heat_capacity: Option<Number>,
}

/// A conductivity, W/(m K): a number, an expression of the temperature `T` (K), or a table of pairs of
/// temperature and conductivity, straight between them and constant beyond.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct ConductivitySpec(Value);

impl JsonSchema for ConductivitySpec {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Conductivity".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let number = generator.subschema_for::<Number>();
        schemars::json_schema!({
            "description": "A conductivity, W/(m K): a number, an expression of the temperature T (K), or a \
                            table of pairs [T, conductivity], straight between them and constant beyond.",
            "anyOf": [
                number.clone(),
                {
                    "type": "array", "minItems": 1,
                    "items": { "type": "array", "items": number, "minItems": 2, "maxItems": 2 }
                }
            ]
        })
    }
}

/// A melting point, K, or the two temperatures between which a material melts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct MeltingTemperature(Value);

impl JsonSchema for MeltingTemperature {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "MeltingTemperature".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let number = generator.subschema_for::<Number>();
        schemars::json_schema!({
            "description": "A melting point, K, or the temperatures at which melting begins and ends.",
            "anyOf": [
                number.clone(),
                { "type": "array", "items": number, "minItems": 2, "maxItems": 2 }
            ]
        })
    }
}

/// How far a table for an expression may be from it, of the conductivity.
const STRAIGHT: f64 = 1e-6;

/// How far an expression is looked at: to so many times the largest temperature that is known.
const BEYOND: f64 = 10.0;

/// At how many temperatures that the scene has an expression is tried.
const TRIALS: u32 = 1000;

impl MaterialSpec {
    /// Whether it has what heat needs.
    pub(super) fn is_thermal(&self) -> bool {
        self.diffusivity.is_none()
    }

    /// Whether what it conducts, or its heat, may depend on its temperature.
    pub(super) fn depends_on_temperature(&self) -> bool {
        let liquid = self.liquid.as_ref().and_then(|liquid| liquid.conductivity.as_ref());
        let mut conductivities = self.conductivity.iter().chain(liquid);
        self.melting_temperature.is_some() || conductivities.any(|spec| !spec.0.is_number())
    }

    /// Writes down what is taken where nothing is given.
    pub(super) fn fill_in_defaults(&mut self) {
        self.density.get_or_insert(DEFAULT_DENSITY.into());
    }

    /// The material `name`. A conductivity that is an expression of the temperature is taken for those of
    /// `range` (K) and far around; without it, anything stands for that.
    pub(super) fn resolve(
        &self,
        name: &str,
        evaluator: &Evaluator,
        range: Option<[f64; 2]>,
    ) -> Result<Material, CaseError> {
        let path = |key: &str| format!("materials.{name}.{key}");
        let positive = |key: &str, number: &Number| evaluator.positive(&path(key), number);
        if let Some(diffusivity) = &self.diffusivity {
            self.refuse_heat(&path)?;
            let diffusivity = positive("diffusivity", diffusivity)?;
            let density = self.density.as_ref();
            let density = density.map_or(Ok(DEFAULT_DENSITY), |rho| positive("density", rho))?;
            return Ok(Material::diffusive(name, diffusivity, density));
        }
        if self.conductivity.is_none() && self.heat_capacity.is_none() {
            return Err(CaseError::MissingKey { path: path("diffusivity") });
        }
        let missing = |key: &str| CaseError::MissingKey { path: path(key) };
        let conductivity = self.conductivity.as_ref().ok_or_else(|| missing("conductivity"))?;
        let needed = |key: &str, number: &Option<Number>| match number {
            Some(number) => positive(key, number),
            None => Err(missing(key)),
        };
        let density = needed("density", &self.density)?;
        let capacity = density * needed("heat_capacity", &self.heat_capacity)?;
        let melting = self.melting_range(evaluator, &path)?;
        let range = range.map(|range| melting.map_or(range, |melting| joined(range, melting)));
        let solid = conductivity.resolve(&path("conductivity"), evaluator, range)?;
        let melting = melting
            .map(|melts| self.melting(melts, evaluator, &path, range, [density, capacity], &solid))
            .transpose()?;
        Ok(Material::thermal(name, &solid, capacity, melting.as_ref(), density))
    }

    /// Refuses what belongs to heat, of a material that has a diffusivity.
    fn refuse_heat(&self, path: &dyn Fn(&str) -> String) -> Result<(), CaseError> {
        let of_heat = [
            ("conductivity", self.conductivity.is_some()),
            ("heat_capacity", self.heat_capacity.is_some()),
            ("melting_temperature", self.melting_temperature.is_some()),
            ("latent_heat", self.latent_heat.is_some()),
            ("liquid", self.liquid.is_some()),
        ];
        let Some((key, _)) = of_heat.into_iter().find(|(_, is_given)| *is_given) else {
            return Ok(());
        };
        let reason = "the material has a diffusivity; heat needs conductivity, density and heat_capacity \
                      instead";
        Err(CaseError::UnusedKey { path: path(key), reason: reason.to_owned() })
    }

    /// The temperatures at which melting begins and ends, K.
    fn melting_range(
        &self,
        evaluator: &Evaluator,
        path: &dyn Fn(&str) -> String,
    ) -> Result<Option<[f64; 2]>, CaseError> {
        let Some(MeltingTemperature(written)) = &self.melting_temperature else {
            let unused =
                [("latent_heat", self.latent_heat.is_some()), ("liquid", self.liquid.is_some())];
            return match unused.into_iter().find(|(_, is_given)| *is_given) {
                Some((key, _)) => Err(CaseError::UnusedKey {
                    path: path(key),
                    reason: "the material has no melting_temperature".to_owned(),
                }),
                None => Ok(None),
            };
        };
        let path = path("melting_temperature");
        let number = |path: &str, value: &Value| evaluator.number(path, &Number(value.clone()));
        let Value::Array(two) = written else {
            let at = number(&path, written)?;
            return Ok(Some([at, at]));
        };
        let [from, to] = &two[..] else {
            let reason = format!("expected one temperature or two, found {}", two.len());
            return Err(CaseError::WrongType { path, reason });
        };
        let from = number(&format!("{path}[0]"), from)?;
        let to_path = format!("{path}[1]");
        let to = number(&to_path, to)?;
        in_range(&to_path, to, to >= from, "no less than where melting begins")?;
        Ok(Some([from, to]))
    }

    fn melting(
        &self,
        [solidus, liquidus]: [f64; 2],
        evaluator: &Evaluator,
        path: &dyn Fn(&str) -> String,
        range: Option<[f64; 2]>,
        [density, capacity]: [f64; 2],
        solid: &Conductivity,
    ) -> Result<Melting, CaseError> {
        let latent = self.latent_heat.as_ref();
        let latent = latent.ok_or_else(|| CaseError::MissingKey { path: path("latent_heat") })?;
        let latent = density * evaluator.positive(&path("latent_heat"), latent)?;
        let none = LiquidSpec::default();
        let liquid = self.liquid.as_ref().unwrap_or(&none);
        let conductivity = match &liquid.conductivity {
            Some(spec) => spec.resolve(&path("liquid.conductivity"), evaluator, range)?,
            None => solid.clone(),
        };
        let or_solid = |key: &str, number: &Option<Number>, of_solid: f64| match number {
            Some(number) => evaluator.positive(&path(&format!("liquid.{key}")), number),
            None => Ok(of_solid),
        };
        let heat_capacity = or_solid("heat_capacity", &liquid.heat_capacity, capacity / density)?;
        let capacity = heat_capacity * or_solid("density", &liquid.density, density)?;
        Ok(Melting { solidus, liquidus, latent, conductivity, capacity })
    }
}

fn joined(range: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    [range[0].min(other[0]), range[1].max(other[1])]
}

impl ConductivitySpec {
    fn resolve(
        &self,
        path: &str,
        evaluator: &Evaluator,
        range: Option<[f64; 2]>,
    ) -> Result<Conductivity, CaseError> {
        if let Value::Array(pairs) = &self.0 {
            return table(path, pairs, evaluator);
        }
        let function = match evaluator.of_temperature(path, &Number(self.0.clone()))? {
            OfTemperature::Constant(value) => {
                return Ok(Conductivity::constant(in_range(path, value, value > 0.0, "positive")?));
            }
            OfTemperature::Function(function) => function,
        };
        let Some([least, most]) = range else {
            return Ok(Conductivity::constant(1.0));
        };
        for trial in 0..=TRIALS {
            let temperature = least + (most - least) * f64::from(trial) / f64::from(TRIALS);
            let value = function(temperature);
            let requirement =
                format!("positive and finite at T = {temperature} K, which the scene has");
            in_range(path, value, value > 0.0 && value.is_finite(), &requirement)?;
        }
        let size = least.abs().max(most.abs()).max(1.0);
        // Above absolute zero, where temperatures are absolute.
        let from = if least > 0.0 { least / BEYOND } else { least - BEYOND * size };
        let range = [from, BEYOND * size];
        let (points, limits) = straightened(&*function, range, [least, most], STRAIGHT);
        Ok(Conductivity::of_points(points).within_limits(limits))
    }
}

/// A table of temperatures and conductivities.
fn table(path: &str, pairs: &[Value], evaluator: &Evaluator) -> Result<Conductivity, CaseError> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    for (index, pair) in pairs.iter().enumerate() {
        let path = format!("{path}[{index}]");
        let Some([temperature, conductivity]) = pair.as_array().map(Vec::as_slice) else {
            let reason = format!("expected a pair [T, conductivity], found {pair}");
            return Err(CaseError::WrongType { path, reason });
        };
        let at = format!("{path}[0]");
        let temperature = evaluator.number(&at, &Number(temperature.clone()))?;
        let ascends = points.last().is_none_or(|last| last[0] < temperature);
        in_range(&at, temperature, ascends, "above the temperature before")?;
        let conductivity =
            evaluator.positive(&format!("{path}[1]"), &Number(conductivity.clone()))?;
        points.push([temperature, conductivity]);
    }
    if points.is_empty() {
        let reason = "the table is empty".to_owned();
        return Err(CaseError::WrongType { path: path.to_owned(), reason });
    }
    Ok(Conductivity::of_points(points))
}

/// The index of the material of this name, of all `names`.
pub(super) fn material_index<'a>(
    path: &str,
    name: &str,
    names: impl Iterator<Item = &'a String> + Clone,
) -> Result<usize, CaseError> {
    names.clone().position(|known| known == name).ok_or_else(|| {
        let known: Vec<String> = names.cloned().collect();
        let nearest = nearest(name, &known, 1);
        CaseError::UnknownName { path: path.to_owned(), text: name.to_owned(), nearest, known }
    })
}

/// The material of this name.
pub(super) fn material_by_name<'a>(
    path: &str,
    name: &str,
    materials: &'a [Material],
) -> Result<&'a Material, CaseError> {
    let names = materials.iter().map(|material| &material.name);
    Ok(&materials[material_index(path, name, names)?])
}
