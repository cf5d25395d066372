//! Solutions for bodies with walls: specs, and how the scene fills in what they leave out.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::setting::{Setting, undetermined};
use crate::case::error::CaseError;
use crate::case::material::material_by_name;
use crate::case::number::{Number, Point, in_range};
use crate::case::schema::Axis;
use crate::case::wall::{ConvectionSpec, WallKindSpec};
use crate::exact::{
    Annulus, AnnulusSetup, HalfSpace, OscillatingSlab, OscillatingSlabSetup, Side, Slab, SlabSetup,
    Sphere, SphereSetup,
};
use crate::exact::{Contact, HalfBody, QuenchedBox};
use crate::model::{Face, Wall, WallKind};

/// A slab between two plane faces, from a uniform initial value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct SlabSpec {
    axis: Axis,
    /// Coordinate of the left face, m; the domain's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    from: Option<Number>,
    /// Coordinate of the right face, m; the domain's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    to: Option<Number>,
    /// What the left face does; what its wall does where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    left: Option<WallKindSpec>,
    /// What the right face does; what its wall does where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    right: Option<WallKindSpec>,
    initial: Number,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    diffusivity: Option<Number>,
}

/// A body without end on the far side of a plane surface, from a uniform initial value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct HalfSpaceSpec {
    axis: Axis,
    /// Coordinate of the surface, m; the domain's lower face where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    from: Option<Number>,
    /// What the surface does; what the wall on the lower face does where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    surface: Option<WallKindSpec>,
    initial: Number,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    diffusivity: Option<Number>,
}

/// A solid sphere, from a uniform initial value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct SphereSpec {
    center: Point,
    radius: Number,
    /// What its surface does.
    surface: WallKindSpec,
    initial: Number,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    diffusivity: Option<Number>,
}

/// What lies between two concentric circles that are held, from a uniform initial value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct AnnulusSpec {
    center: Point,
    inner_radius: Number,
    outer_radius: Number,
    /// Value of the inner circle.
    inner: Number,
    /// Value of the outer circle.
    outer: Number,
    initial: Number,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    diffusivity: Option<Number>,
}

/// A slab whose left face swings: mean + amplitude sin(angular_frequency t).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct OscillatingSlabSpec {
    axis: Axis,
    /// Coordinate of the left face, m; the domain's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    from: Option<Number>,
    /// Coordinate of the right face, m; the domain's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    to: Option<Number>,
    mean: Number,
    amplitude: Number,
    /// rad/s
    angular_frequency: Number,
    /// Value of the right face.
    right: Number,
    initial: Number,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    diffusivity: Option<Number>,
}

/// A box from a uniform initial value, whose faces are held at one value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct QuenchedBoxSpec {
    /// Lower corner; the domain's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    min: Option<Point>,
    /// Upper corner; the domain's where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    max: Option<Point>,
    /// Value of the faces across every axis that is not periodic.
    wall: Number,
    initial: Number,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    diffusivity: Option<Number>,
}

/// Two bodies that touch in a plane, each from a uniform initial value and so long that its far end
/// notices nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub(in crate::case) struct ContactSpec {
    axis: Axis,
    /// Coordinate of the plane, m.
    at: Number,
    /// The body below it.
    below: HalfBodySpec,
    /// The body above it.
    above: HalfBodySpec,
}

/// One of two bodies that touch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct HalfBodySpec {
    /// Name of a material.
    material: String,
    initial: Number,
}

impl QuenchedBoxSpec {
    pub(super) fn resolve(&self, setting: &Setting<'_>) -> Result<QuenchedBox, CaseError> {
        let walls = setting.walls(&self.min, &self.max, &self.diffusivity)?;
        let is_open = |axis: &usize| !setting.domain.periodic[*axis];
        let axes: Vec<usize> = (0..walls.dimension).filter(is_open).collect();
        let values = [setting.given("wall", &self.wall)?, setting.given("initial", &self.initial)?];
        Ok(QuenchedBox::new(&axes, [walls.min, walls.max], values, walls.diffusivity))
    }
}

impl ContactSpec {
    pub(super) fn resolve(&self, setting: &Setting<'_>) -> Result<Contact, CaseError> {
        let body = |key: &str, spec: &HalfBodySpec| -> Result<HalfBody, CaseError> {
            let path = format!("exact.{key}.material");
            let material = material_by_name(&path, &spec.material, setting.materials)?;
            Ok(HalfBody {
                initial: setting.given(&format!("{key}.initial"), &spec.initial)?,
                conductivity: material.conductivity,
                capacity: material.capacity,
            })
        };
        Ok(Contact {
            axis: setting.axis(self.axis)?,
            at: setting.given("at", &self.at)?,
            bodies: [body("below", &self.below)?, body("above", &self.above)?],
        })
    }
}

impl SlabSpec {
    pub(super) fn resolve(&self, setting: &Setting<'_>) -> Result<Slab, CaseError> {
        let axis = setting.axis(self.axis)?;
        let (from, to) = extent(setting, axis, &self.from, &self.to)?;
        let side = |key, side, upper| side_or_wall(setting, key, side, Face { axis, upper });
        Ok(Slab::new(SlabSetup {
            axis,
            from,
            to,
            left: side("left", &self.left, false)?,
            right: side("right", &self.right, true)?,
            initial: setting.given("initial", &self.initial)?,
            diffusivity: setting.diffusivity(&self.diffusivity)?,
        }))
    }
}

impl HalfSpaceSpec {
    pub(super) fn resolve(&self, setting: &Setting<'_>) -> Result<HalfSpace, CaseError> {
        let axis = setting.axis(self.axis)?;
        let face = Face { axis, upper: false };
        Ok(HalfSpace {
            axis,
            from: setting.number_or("from", &self.from, setting.domain.min[axis])?,
            surface: side_or_wall(setting, "surface", &self.surface, face)?,
            initial: setting.given("initial", &self.initial)?,
            diffusivity: setting.diffusivity(&self.diffusivity)?,
        })
    }
}

impl SphereSpec {
    pub(super) fn resolve(&self, setting: &Setting<'_>) -> Result<Sphere, CaseError> {
        let three = setting.evaluator.dimension == 3;
        in_range("dimension", setting.evaluator.dimension as f64, three, "3 for a sphere")?;
        Ok(Sphere::new(SphereSetup {
            center: setting.evaluator.point("exact.center", &self.center)?,
            radius: setting.evaluator.positive("exact.radius", &self.radius)?,
            surface: side(setting, "surface", &self.surface)?,
            initial: setting.given("initial", &self.initial)?,
            diffusivity: setting.diffusivity(&self.diffusivity)?,
        }))
    }
}

impl AnnulusSpec {
    pub(super) fn resolve(&self, setting: &Setting<'_>) -> Result<Annulus, CaseError> {
        let dimension = setting.evaluator.dimension;
        in_range("dimension", dimension as f64, dimension >= 2, "2 or 3 for an annulus")?;
        let path = "exact.inner_radius";
        let inner_radius = setting.evaluator.positive(path, &self.inner_radius)?;
        let outer_radius = setting.evaluator.positive("exact.outer_radius", &self.outer_radius)?;
        in_range(path, inner_radius, inner_radius < outer_radius, "below the outer radius")?;
        let center: DVec3 = setting.evaluator.point("exact.center", &self.center)?;
        Ok(Annulus::new(AnnulusSetup {
            center,
            inner_radius,
            outer_radius,
            inner: setting.given("inner", &self.inner)?,
            outer: setting.given("outer", &self.outer)?,
            initial: setting.given("initial", &self.initial)?,
            diffusivity: setting.diffusivity(&self.diffusivity)?,
        }))
    }
}

impl OscillatingSlabSpec {
    pub(super) fn resolve(&self, setting: &Setting<'_>) -> Result<OscillatingSlab, CaseError> {
        let axis = setting.axis(self.axis)?;
        let (from, to) = extent(setting, axis, &self.from, &self.to)?;
        let path = "exact.angular_frequency";
        Ok(OscillatingSlab::new(OscillatingSlabSetup {
            axis,
            from,
            to,
            mean: setting.given("mean", &self.mean)?,
            amplitude: setting.given("amplitude", &self.amplitude)?,
            angular_frequency: setting.evaluator.positive(path, &self.angular_frequency)?,
            right: setting.given("right", &self.right)?,
            initial: setting.given("initial", &self.initial)?,
            diffusivity: setting.diffusivity(&self.diffusivity)?,
        }))
    }
}

/// Coordinates of the faces of a slab, the domain's where absent.
pub(super) fn extent(
    setting: &Setting<'_>,
    axis: usize,
    from: &Option<Number>,
    to: &Option<Number>,
) -> Result<(f64, f64), CaseError> {
    let from = setting.number_or("from", from, setting.domain.min[axis])?;
    let to = setting.number_or("to", to, setting.domain.max[axis])?;
    in_range("exact.to", to, to > from, "above exact.from")?;
    Ok((from, to))
}

/// What a face is held at as written; as the scene's wall on `face` does where absent.
pub(super) fn held_value(
    setting: &Setting<'_>,
    key: &str,
    written: &Option<Number>,
    face: Face,
) -> Result<f64, CaseError> {
    if let Some(value) = written {
        return setting.given(key, value);
    }
    match side_of_wall(setting, key, face)? {
        Side::Value(value) => Ok(value),
        _ => Err(undetermined(key, format!("the wall on {} holds no value", face.name()))),
    }
}

/// What a face does as written; as the scene's wall on `face` does where absent.
fn side_or_wall(
    setting: &Setting<'_>,
    key: &str,
    written: &Option<WallKindSpec>,
    face: Face,
) -> Result<Side, CaseError> {
    match written {
        Some(kind) => side(setting, key, kind),
        None => side_of_wall(setting, key, face),
    }
}

/// What a face does as written.
fn side(setting: &Setting<'_>, key: &str, kind: &WallKindSpec) -> Result<Side, CaseError> {
    let given = |part: &str, number| setting.given(&format!("{key}.{part}"), number);
    Ok(match kind {
        WallKindSpec::Free | WallKindSpec::Insulated => Side::INSULATED,
        WallKindSpec::Value(value) => Side::Value(given("value", value)?),
        WallKindSpec::Flux(flux) => Side::Flux(given("flux", flux)? / setting.capacity()?),
        WallKindSpec::Convection(ConvectionSpec { coefficient, ambient }) => {
            let path = format!("exact.{key}.convection.coefficient");
            Side::Convection {
                coefficient: setting.evaluator.not_negative(&path, coefficient)?
                    / setting.capacity()?,
                ambient: given("convection.ambient", ambient)?,
            }
        }
    })
}

/// Whether nothing crosses a wall.
fn is_passive(wall: &Wall) -> bool {
    matches!(wall.condition.kind, WallKind::Free | WallKind::Insulated)
}

/// What the only wall on a face does, if it does the same everywhere and always.
fn side_of_wall(setting: &Setting<'_>, key: &str, face: Face) -> Result<Side, CaseError> {
    let name = face.name();
    let across = |wall: &&Wall| wall.face.axis != face.axis && !is_passive(wall);
    if let Some(wall) = setting.walls.iter().find(across) {
        let reason = format!("the wall on {} acts across the slab", wall.face.name());
        return Err(undetermined(key, reason));
    }
    let unknown = |reason: &str| undetermined(key, format!("the face {name} {reason}"));
    let walls: Vec<_> = setting.walls.iter().filter(|wall| wall.face == face).collect();
    let condition = match walls[..] {
        [wall] if wall.covers.is_none() => &wall.condition,
        [] => return Err(unknown("has no wall")),
        _ => return Err(unknown("has several walls, or a part of one")),
    };
    let varies = [&condition.imposed, &condition.coefficient]
        .into_iter()
        .any(|field| field.depends_on_position() || field.depends_on_time());
    if varies {
        return Err(unknown("has a wall whose values vary"));
    }
    let imposed = condition.imposed.at(DVec3::ZERO, 0.0);
    Ok(match condition.kind {
        WallKind::Free | WallKind::Insulated => Side::INSULATED,
        WallKind::Value => Side::Value(imposed),
        WallKind::Flux => Side::Flux(imposed / setting.capacity()?),
        WallKind::Convection => {
            let coefficient = condition.coefficient.at(DVec3::ZERO, 0.0) / setting.capacity()?;
            Side::Convection { coefficient, ambient: imposed }
        }
    })
}
