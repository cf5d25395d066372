//! The `sources` section.

mod spread;

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::boundary::select;
use super::error::CaseError;
use super::number::{Evaluator, Field, Number, Point, in_range};
use super::shape::ShapeSpec;
use super::wall::Body;
use crate::model::{ScalarField, Source};

use spread::{Place, Spread};

/// What particles get beside what flows between them, in one of two forms: `rate` + `linear` x value in a
/// unit volume, at least one of the two, everywhere or in a shape; or a `power` that enters at a point, or
/// on the way along a path, spread over the particles around by the kernel. Where several sources act they
/// add up. With a diffusivity alone a rate is in value/s and a power in value x volume/s, with a heat
/// capacity they are in W/m3 and W.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "an object")]
#[schemars(extend("oneOf" = [
    { "anyOf": [{ "required": ["rate"] }, { "required": ["linear"] }],
      "properties": { "power": false, "at": false, "path": false, "speed": false, "start": false } },
    { "required": ["power", "at"],
      "properties": { "rate": false, "linear": false, "where": false, "path": false, "speed": false, "start": false } },
    { "required": ["power", "path", "speed"],
      "properties": { "rate": false, "linear": false, "where": false, "at": false } }
]))]
pub(super) struct SourceSpec {
    /// In a unit volume, may depend on x y z t; 0 where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    rate: Option<Number>,
    /// Factor of the value, may depend on x y z: negative for what is lost in proportion to the value,
    /// positive for what grows; 0 where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    linear: Option<Number>,
    /// Where it acts; everywhere where absent. Held particles keep their value.
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    selection: Option<ShapeSpec>,
    /// What enters at a point, may depend on t, and on x y z of the point.
    #[serde(skip_serializing_if = "Option::is_none")]
    power: Option<Number>,
    /// The point.
    #[serde(skip_serializing_if = "Option::is_none")]
    at: Option<Point>,
    /// At least two points; the source moves along the straight lines between them.
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<Vec<Point>>,
    /// How fast, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    speed: Option<Number>,
    /// When it sets out, s; 0 where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    start: Option<Number>,
}

/// The sources of a case, and the times (s) at which one begins or ends.
#[derive(Debug, Default)]
pub(super) struct Sources {
    pub(super) list: Vec<Source>,
    pub(super) breaks: Vec<f64>,
}

/// The sources of a case, none of which acts on the particles `held` (ascending); `end` (s) is that of the
/// simulated time.
pub(super) fn resolve(
    specs: &[SourceSpec],
    body: &Body,
    held: &[u32],
    end: f64,
    warnings: &mut Vec<String>,
) -> Result<Sources, CaseError> {
    let mut sources = Sources::default();
    for (index, spec) in specs.iter().enumerate() {
        let path = format!("sources[{index}]");
        spec.check_form(&path)?;
        let source = match &spec.power {
            Some(power) => {
                let place = spec.place(body, &path)?;
                sources.breaks.extend(place.duration().into_iter().flatten());
                spec.spread(power, place, body, held, &path, warnings)?
            }
            None => spec.in_volume(body, held, &path)?,
        };
        sources.list.push(source);
    }
    sources.breaks.retain(|&time| time > 0.0 && time < end);
    Ok(sources)
}

impl SourceSpec {
    /// The power, if it is constant and enters at a point.
    pub(super) fn constant_power(&self, evaluator: &Evaluator) -> Option<f64> {
        self.at.as_ref()?;
        evaluator.field_in_time("power", self.power.as_ref()?).ok()?.constant
    }

    /// The point where a power enters.
    pub(super) fn point(&self, evaluator: &Evaluator) -> Option<DVec3> {
        evaluator.point("at", self.at.as_ref()?).ok()
    }

    /// The rate, if it is constant and all that enters, everywhere.
    pub(super) fn constant_rate(&self, evaluator: &Evaluator) -> Option<f64> {
        if self.linear.is_some() || self.selection.is_some() {
            return None;
        }
        evaluator.field_in_time("rate", self.rate.as_ref()?).ok()?.constant
    }

    /// Refuses keys of one form beside those of another.
    fn check_form(&self, path: &str) -> Result<(), CaseError> {
        let Self { rate, linear, selection, power, at, path: way, speed, start } = self;
        let forbid = |given: bool, key: &str, reason: &str| match given {
            true => Err(CaseError::UnusedKey {
                path: format!("{path}.{key}"),
                reason: reason.to_owned(),
            }),
            false => Ok(()),
        };
        if power.is_none() {
            let reason = "it belongs to a power";
            forbid(at.is_some(), "at", reason)?;
            forbid(way.is_some(), "path", reason)?;
            forbid(speed.is_some(), "speed", reason)?;
            return forbid(start.is_some(), "start", reason);
        }
        let reason = "the entry has a power already";
        forbid(rate.is_some(), "rate", reason)?;
        forbid(linear.is_some(), "linear", reason)?;
        forbid(selection.is_some(), "where", "a power enters at a point or along a path")?;
        if at.is_some() {
            let reason = "the entry has a point already";
            forbid(way.is_some(), "path", reason)?;
            forbid(speed.is_some(), "speed", reason)?;
            forbid(start.is_some(), "start", reason)?;
        }
        Ok(())
    }

    fn in_volume(&self, body: &Body, held: &[u32], path: &str) -> Result<Source, CaseError> {
        if self.rate.is_none() && self.linear.is_none() {
            return Err(CaseError::MissingKey { path: format!("{path}.rate") });
        }
        let evaluator = body.evaluator;
        let rate = self.rate.as_ref();
        let rate =
            rate.map(|rate| evaluator.field_in_time(&format!("{path}.rate"), rate)).transpose()?;
        let linear = self.linear.as_ref();
        let linear =
            linear.map(|linear| evaluator.field(&format!("{path}.linear"), linear)).transpose()?;
        let select = |spec: &ShapeSpec| {
            let path = format!("{path}.where");
            let shape = spec.resolve(evaluator, &path)?;
            select(body.particles, &shape, body.spacing, &path)
        };
        let mut source = Source {
            name: path.to_owned(),
            particles: self.selection.as_ref().map(select).transpose()?,
            rate: ScalarField::constant(0.0),
            linear: ScalarField::constant(0.0),
        };
        if let Some(rate) = rate {
            check(&rate, &source, body, held)?;
            source.rate = rate.scalar;
        }
        if let Some(linear) = linear {
            check(&linear, &source, body, held)?;
            source.linear = linear.scalar;
        }
        Ok(source)
    }

    fn spread(
        &self,
        power: &Number,
        place: Place,
        body: &Body,
        held: &[u32],
        path: &str,
        warnings: &mut Vec<String>,
    ) -> Result<Source, CaseError> {
        let power = body.evaluator.field_in_time(&format!("{path}.power"), power)?;
        let position = &body.particles.position;
        let reach = body.kernel.cutoff();
        let is_near = |&particle: &u32| {
            let near = place.distance(body.domain, position[particle as usize]) < reach;
            near && held.binary_search(&particle).is_err()
        };
        let near: Vec<u32> = (0..position.len() as u32).filter(is_near).collect();
        if near.is_empty() {
            let key = if self.at.is_some() { "at" } else { "path" };
            return Err(CaseError::SourceInVoid { path: format!("{path}.{key}") });
        }
        if let Place::At(at) = place {
            power.at(at, 0.0)?;
        }
        let away =
            place.way_without(body.domain, near.iter().map(|&p| position[p as usize]), reach);
        if away > 1e-9 * body.spacing {
            warnings.push(format!(
                "{path}.path: no particle that is not held is within a support radius on {away:.3e} m of \
                 it: no power enters there"
            ));
        }
        let text = power.scalar.text().to_owned();
        let member = |&particle: &u32| {
            let particle = particle as usize;
            (position[particle], body.particles.volume[particle])
        };
        let spread = Spread {
            place,
            power: power.scalar,
            kernel: *body.kernel,
            domain: *body.domain,
            members: near.iter().map(member).collect(),
        };
        Ok(Source {
            name: path.to_owned(),
            particles: Some(near),
            rate: spread.into_field(text),
            linear: ScalarField::constant(0.0),
        })
    }

    fn place(&self, body: &Body, path: &str) -> Result<Place, CaseError> {
        let evaluator = body.evaluator;
        if let Some(at) = &self.at {
            return Ok(Place::At(evaluator.point(&format!("{path}.at"), at)?));
        }
        let missing = |key: &str| CaseError::MissingKey { path: format!("{path}.{key}") };
        let way = self.path.as_ref().ok_or_else(|| missing("at"))?;
        let speed = self.speed.as_ref().ok_or_else(|| missing("speed"))?;
        let point = |(k, point)| evaluator.point(&format!("{path}.path[{k}]"), point);
        let points = way.iter().enumerate().map(point).collect::<Result<Vec<_>, _>>()?;
        let length = points.len() as f64;
        in_range(&format!("{path}.path"), length, length >= 2.0, "at least two points")?;
        if let Some(k) = points.windows(2).position(|ends| ends[0] == ends[1]) {
            let reason = "is the point before it".to_owned();
            return Err(CaseError::Shape { path: format!("{path}.path[{}]", k + 1), reason });
        }
        let start = match &self.start {
            Some(start) => evaluator.not_negative(&format!("{path}.start"), start)?,
            None => 0.0,
        };
        let speed = evaluator.positive(&format!("{path}.speed"), speed)?;
        Ok(Place::Along { points, speed, start })
    }
}

/// Refuses a field that is not finite at t = 0 where the source acts on particles that are not held.
fn check(field: &Field, source: &Source, body: &Body, held: &[u32]) -> Result<(), CaseError> {
    let position = &body.particles.position;
    let is_free = |particle: &usize| held.binary_search(&(*particle as u32)).is_err();
    let mut particles = source.indices(position.len()).filter(is_free);
    particles.try_for_each(|particle| field.at(position[particle], 0.0).map(|_| ()))
}
