//! Solutions with a phase change: specs, and what they refuse.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::bodies::held_value;
use super::setting::Setting;
use crate::case::error::CaseError;
use crate::case::number::{Number, in_range};
use crate::case::schema::Axis;
use crate::exact::{Neumann, NeumannSetup, Phase};
use crate::model::Face;

/// A half space that melts or freezes from its held surface on, from a uniform temperature.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct NeumannSpec {
    axis: Axis,
    /// Coordinate of the surface, m; that of the domain's face where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    at: Option<Number>,
    #[serde(default)]
    body: BodySpec,
    /// Temperature at t = 0, K: the melting temperature, or across it from the wall's.
    initial: Number,
    /// Held temperature of the surface, K; that of the wall on the domain's face where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    wall: Option<Number>,
    /// K; the only material's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    melting_temperature: Option<Number>,
    /// Of a unit volume, J/m3; the only material's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    latent_heat: Option<Number>,
    /// Below the melting temperature; the only material's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    solid: Option<PhaseSpec>,
    /// Above the melting temperature; the only material's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    liquid: Option<PhaseSpec>,
}

/// A half space that melts or freezes from its held surface on, from the melting temperature.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct StefanSpec {
    axis: Axis,
    /// Coordinate of the surface, m; that of the domain's face where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    at: Option<Number>,
    #[serde(default)]
    body: BodySpec,
    /// Held temperature of the surface, K; that of the wall on the domain's face where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    wall: Option<Number>,
    /// K; that of the whole body at t = 0; the only material's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    melting_temperature: Option<Number>,
    /// Of a unit volume, J/m3; the only material's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    latent_heat: Option<Number>,
    /// The phase that grows from the surface; the only material's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    phase: Option<PhaseSpec>,
}

/// On which side of its surface a body lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum BodySpec {
    #[default]
    Above,
    Below,
}

/// What conducts heat in one phase.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
#[schemars(extend("required" = ["conductivity", "capacity"]))]
struct PhaseSpec {
    /// W/(m K)
    #[serde(default, skip_serializing_if = "Option::is_none")]
    conductivity: Option<Number>,
    /// Capacity rho c of a unit volume, J/(m3 K).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    capacity: Option<Number>,
}

/// A phase as given, or that of the only material.
fn phase(
    setting: &Setting<'_>,
    key: &str,
    spec: &Option<PhaseSpec>,
    is_solid: bool,
) -> Result<Phase, CaseError> {
    if let Some(spec) = spec {
        return spec.resolve(setting, key);
    }
    let (solid, liquid) = setting.melting(key)?;
    Ok(match is_solid {
        true => Phase { conductivity: solid.conductivity, capacity: solid.capacity },
        false => {
            let conductivity = liquid.conductivity.at(liquid.liquidus);
            Phase { conductivity, capacity: liquid.capacity }
        }
    })
}

impl PhaseSpec {
    fn resolve(&self, setting: &Setting<'_>, key: &str) -> Result<Phase, CaseError> {
        let positive = |part: &str, number: &Option<Number>| {
            let path = format!("exact.{key}.{part}");
            match number {
                Some(number) => setting.evaluator.positive(&path, number),
                None => Err(CaseError::MissingKey { path }),
            }
        };
        Ok(Phase {
            conductivity: positive("conductivity", &self.conductivity)?,
            capacity: positive("capacity", &self.capacity)?,
        })
    }
}

impl NeumannSpec {
    pub(super) fn resolve(&self, setting: &Setting<'_>) -> Result<Neumann, CaseError> {
        let surface = surface(setting, self.axis, &self.at, self.body, &self.wall)?;
        let change = change(setting, &surface, &self.melting_temperature, &self.latent_heat)?;
        let initial = setting.given("initial", &self.initial)?;
        let ([melting, _], path) = (change, "exact.initial");
        if surface.wall > melting {
            let allowed = "at most the melting temperature, since the wall is above it";
            in_range(path, initial, initial <= melting, allowed)?;
        } else {
            let allowed = "at least the melting temperature, since the wall is below it";
            in_range(path, initial, initial >= melting, allowed)?;
        }
        let solid = phase(setting, "solid", &self.solid, true)?;
        let liquid = phase(setting, "liquid", &self.liquid, false)?;
        Ok(half_space(&surface, change, initial, [solid, liquid]))
    }
}

impl StefanSpec {
    pub(super) fn resolve(&self, setting: &Setting<'_>) -> Result<Neumann, CaseError> {
        let surface = surface(setting, self.axis, &self.at, self.body, &self.wall)?;
        let change = change(setting, &surface, &self.melting_temperature, &self.latent_heat)?;
        // The other phase stays at the melting temperature, whatever it conducts.
        let phase = phase(setting, "phase", &self.phase, surface.wall < change[0])?;
        Ok(half_space(&surface, change, change[0], [phase; 2]))
    }
}

/// A held surface, and where the body is.
struct Surface {
    axis: usize,
    at: f64,
    above: bool,
    wall: f64,
}

fn surface(
    setting: &Setting<'_>,
    axis: Axis,
    at: &Option<Number>,
    body: BodySpec,
    wall: &Option<Number>,
) -> Result<Surface, CaseError> {
    let (axis, above) = (setting.axis(axis)?, body == BodySpec::Above);
    let face = Face { axis, upper: !above };
    let at = setting.number_or("at", at, face.coordinate(setting.domain))?;
    let wall = held_value(setting, "wall", wall, face)?;
    Ok(Surface { axis, at, above, wall })
}

/// Melting temperature and latent heat.
fn change(
    setting: &Setting<'_>,
    surface: &Surface,
    melting: &Option<Number>,
    latent_heat: &Option<Number>,
) -> Result<[f64; 2], CaseError> {
    let melting = match melting {
        Some(melting) => setting.given("melting_temperature", melting)?,
        None => setting.melting("melting_temperature")?.1.solidus,
    };
    let latent_heat = match latent_heat {
        Some(latent_heat) => setting.evaluator.positive("exact.latent_heat", latent_heat)?,
        None => setting.melting("latent_heat")?.1.latent,
    };
    let differs = surface.wall != melting;
    in_range("exact.wall", surface.wall, differs, "above or below the melting temperature")?;
    Ok([melting, latent_heat])
}

fn half_space(
    surface: &Surface,
    [melting, latent_heat]: [f64; 2],
    initial: f64,
    [solid, liquid]: [Phase; 2],
) -> Neumann {
    let Surface { axis, at, above, wall } = *surface;
    Neumann::new(NeumannSetup {
        axis,
        at,
        above,
        initial,
        wall,
        melting,
        latent_heat,
        solid,
        liquid,
    })
}
