//! What a scene gives to its exact solution.

use glam::DVec3;

use crate::case::boundary::axis_index;
use crate::case::error::CaseError;
use crate::case::number::{Evaluator, Number, Point, in_range};
use crate::case::schema::Axis;
use crate::case::source::SourceSpec;
use crate::exact::ZeroFluxBox;
use crate::model::{Domain, Material, Melting, Wall};

/// What the scene says about its exact solution.
pub(in crate::case) struct Setting<'a> {
    pub(in crate::case) evaluator: &'a Evaluator,
    pub(in crate::case) domain: &'a Domain,
    pub(in crate::case) spacing: f64,
    pub(in crate::case) materials: &'a [Material],
    pub(in crate::case) walls: &'a [Wall],
    pub(in crate::case) sources: &'a [SourceSpec],
    /// Amount and place of every deposit.
    pub(in crate::case) deposits: &'a [(f64, DVec3)],
}

impl Setting<'_> {
    pub(super) fn given(&self, key: &str, number: &Number) -> Result<f64, CaseError> {
        self.evaluator.number(&format!("exact.{key}"), number)
    }

    pub(super) fn number_or(
        &self,
        key: &str,
        number: &Option<Number>,
        default: f64,
    ) -> Result<f64, CaseError> {
        number.as_ref().map_or(Ok(default), |number| self.given(key, number))
    }

    pub(super) fn positive_or(
        &self,
        key: &str,
        number: &Option<Number>,
        default: f64,
    ) -> Result<f64, CaseError> {
        let path = format!("exact.{key}");
        number.as_ref().map_or(Ok(default), |number| self.evaluator.positive(&path, number))
    }

    /// The share of the volume that takes up the substance, 1 where absent.
    pub(super) fn porosity(&self, number: &Option<Number>) -> Result<f64, CaseError> {
        let porosity = self.number_or("porosity", number, 1.0)?;
        let allowed = porosity > 0.0 && porosity <= 1.0;
        in_range("exact.porosity", porosity, allowed, "above 0 and at most 1")
    }

    pub(super) fn axis(&self, axis: Axis) -> Result<usize, CaseError> {
        axis_index(axis, "exact.axis", self.evaluator.dimension)
    }

    pub(super) fn diffusivity(&self, number: &Option<Number>) -> Result<f64, CaseError> {
        match (number, self.materials) {
            (Some(number), _) => self.evaluator.positive("exact.diffusivity", number),
            (None, [material]) if material.curve.is_some() => Err(undetermined(
                "diffusivity",
                "the material's properties depend on temperature".to_owned(),
            )),
            (None, [material]) => Ok(material.diffusivity()),
            (None, materials) => Err(undetermined(
                "diffusivity",
                format!("the case has {} materials", materials.len()),
            )),
        }
    }

    /// Capacity rho c of a unit volume, 1 where there is only a diffusivity.
    pub(super) fn capacity(&self) -> Result<f64, CaseError> {
        let mut capacities = self.materials.iter().map(|material| material.capacity);
        let first = capacities.next().unwrap_or(1.0);
        match capacities.all(|other| other == first) {
            true => Ok(first),
            false => Err(undetermined("capacity", "the materials differ in it".to_owned())),
        }
    }

    /// The only material and how it melts, with a sharp melting point and constant properties in each phase.
    pub(super) fn melting(&self, key: &str) -> Result<(&Material, &Melting), CaseError> {
        let unknown = |reason: &str| undetermined(key, reason.to_owned());
        let [material] = self.materials else {
            return Err(unknown("the case has several materials"));
        };
        let melt = material.curve.as_ref().and_then(|curve| curve.melt());
        let melt = melt.ok_or_else(|| unknown("the material does not melt"))?;
        match melt.solidus == melt.liquidus && material.is_constant_in_phases() {
            true => Ok((material, melt)),
            false => Err(unknown(
                "the material has no sharp melting point, or conductivities that depend on temperature",
            )),
        }
    }

    /// What was deposited over the capacity of a unit volume, and where.
    pub(super) fn deposit(
        &self,
        amount: &Option<Number>,
        at: &Option<Point>,
    ) -> Result<(f64, DVec3), CaseError> {
        let only = match self.deposits {
            [only] => Some(*only),
            _ => None,
        };
        let unknown =
            |key| undetermined(key, format!("the case has {} deposits", self.deposits.len()));
        let amount = match (amount, only) {
            (Some(amount), _) => self.given("amount", amount)?,
            (None, Some((amount, _))) => amount,
            (None, None) => return Err(unknown("amount")),
        };
        let at = match (at, only) {
            (Some(at), _) => self.evaluator.point("exact.at", at)?,
            (None, Some((_, at))) => at,
            (None, None) => return Err(unknown("at")),
        };
        Ok((amount / self.capacity()?, at))
    }

    /// What `part` takes from the only source, which is to be `wanted`.
    pub(super) fn only_source<T>(
        &self,
        key: &str,
        wanted: &str,
        part: impl Fn(&SourceSpec, &Evaluator) -> Option<T>,
    ) -> Result<T, CaseError> {
        let [only] = self.sources else {
            return Err(undetermined(key, format!("the case has {} sources", self.sources.len())));
        };
        part(only, self.evaluator)
            .ok_or_else(|| undetermined(key, format!("the source is not {wanted}")))
    }

    pub(super) fn walls(
        &self,
        min: &Option<Point>,
        max: &Option<Point>,
        diffusivity: &Option<Number>,
    ) -> Result<ZeroFluxBox, CaseError> {
        let corner = |key: &str, corner: &Option<Point>, default| match corner {
            Some(point) => self.evaluator.point(&format!("exact.{key}"), point),
            None => Ok(default),
        };
        let min = corner("min", min, self.domain.min)?;
        let max = corner("max", max, self.domain.max)?;
        let dimension = self.evaluator.dimension;
        for axis in 0..dimension {
            let path = format!("exact.max[{axis}]");
            in_range(&path, max[axis], max[axis] > min[axis], "above exact.min")?;
        }
        Ok(ZeroFluxBox { dimension, min, max, diffusivity: self.diffusivity(diffusivity)? })
    }
}

pub(super) fn undetermined(key: &str, reason: String) -> CaseError {
    CaseError::Undetermined { path: format!("exact.{key}"), reason }
}
