//! Where materials meet of which one's conductivity depends on temperature, or which melts, on the device.

use super::curve_passes::SeamPasses;
use super::enthalpy::{Curves, Enthalpy, HeatFields};
use super::fronts::Listed;
use super::passes::NO_SLOT;
use super::phases::Told;
use crate::gpu::{Buffer, Device, GpuError, Pass, PassSource};
use crate::model::material::Segment;
use crate::model::operator::Seams;
use crate::model::{HeatCurve, Problem};
use crate::solver::precision::two_words;

/// What the matrix, or what steps write, is short of there, row by row: see `shaders/seams/rows.wgsl`.
#[derive(Debug)]
pub(super) struct DeviceSeams {
    passes: SeamPasses,
    count: u64,
    /// Temperatures of segments.
    of_segments: Buffer,
    /// Temperatures of phases, where potentials tell enthalpies.
    of_phases: Option<Buffer>,
    /// Rows and pairs.
    rows: [Buffer; 2],
    /// Weights of pairs, and those that a step of enthalpies has before this, where they differ.
    weights: Buffer,
    written: Option<Buffer>,
}

/// What a pass over the rows reads and writes.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeamFields<'a> {
    /// The block with a zero that compilers do not know, and the step over the reference step.
    pub(super) step_size: &'a Buffer,
    /// The state.
    pub(super) enthalpy: &'a Enthalpy,
    /// In which of its two places that is.
    pub(super) from: usize,
    /// What is added to.
    pub(super) after: &'a Buffer,
}

impl DeviceSeams {
    /// The `seams` of `problem`, whose particles follow `curves` and of which those in the places `held` (ascending) are
    /// held; weights are relative to `reference_step` (s).
    pub(super) fn new(
        device: &Device,
        problem: &Problem,
        curves: &Curves,
        seams: &Seams,
        held: &[u32],
        reference_step: f64,
        passes: SeamPasses,
    ) -> Result<Self, GpuError> {
        let scale = 1.0 / curves.largest_reference();
        let (mut rows, mut others, mut weights) =
            (Vec::new(), Vec::new(), [(); 2].map(|()| Vec::new()));
        for row in seams.rows() {
            let first = others.len() as u32;
            for &(other, material, [weight, written]) in &row.pairs {
                let of = |m: u16| scale * problem.materials[usize::from(m)].conductivity;
                let mean = problem.pair_mean.of(of(row.material), of(material));
                others.push(other);
                for (weights, before) in weights.iter_mut().zip([weight, written]) {
                    weights.extend([reference_step * before, reference_step * weight / mean]);
                }
            }
            let among_held = held.binary_search(&row.place).map_or(NO_SLOT, |k| k as u32);
            rows.push([row.place, first, others.len() as u32, among_held]);
        }
        let real = passes.precision.real();
        let table = |name, of: Vec<f64>| device.storage_with(name, &real.to_bytes(&of));
        let of_segments = curves.list().iter().flat_map(temperatures).collect();
        let of_phases = Told::is_of(curves, passes.precision).then(|| {
            let of_curve = |curve: &HeatCurve| temperatures_of_phases(curve, scale);
            table("temperatures of phases", curves.list().iter().flat_map(of_curve).collect())
        });
        let [of_matrix, written] = weights;
        let written = (written != of_matrix).then(|| table("written weights of seams", written));
        Ok(Self {
            passes,
            count: rows.len() as u64,
            of_segments: table("temperatures of curves", of_segments)?,
            of_phases: of_phases.transpose()?,
            rows: [
                device.storage_with("rows of seams", bytemuck::cast_slice(&rows))?,
                device.storage_with("pairs of seams", bytemuck::cast_slice(&others))?,
            ],
            weights: table("weights of seams", of_matrix)?,
            written: written.transpose()?,
        })
    }

    /// Adds to a step of enthalpies what it is short of as it is written, from potentials before it to those after it; held
    /// particles give to `exchange`.
    pub(super) fn step(
        &self,
        device: &Device,
        step_size: &Buffer,
        heat: HeatFields<'_>,
        [before, after]: [&Buffer; 2],
        exchange: Option<&Buffer>,
    ) -> Result<Pass, GpuError> {
        let HeatFields { enthalpy, from, .. } = heat;
        let exchange = exchange.filter(|_| self.passes.has_held());
        let fields = SeamFields { step_size, enthalpy, from, after };
        let content_after = &enthalpy.parts(1 - from)[0];
        let weights = self.written.as_ref().unwrap_or(&self.weights);
        if let (Some(of_phases), Some(phases)) = (&self.of_phases, enthalpy.phase_table()) {
            let noted = heat.noted_in(Listed::Near);
            let source = self.passes.step_of_told(noted.is_some());
            // Which material each place has is the second of the buffers of curves.
            let tables = [&enthalpy.curve()[1], of_phases];
            let more = [before, phases].into_iter().chain(noted.into_iter().flatten());
            self.pass_with(device, &source, tables, weights, fields, more.chain(exchange))
        } else {
            let noted = heat.noted_in(Listed::Melting);
            let source = self.passes.step(noted.is_some());
            let tables = self.of_curves(enthalpy);
            let more = std::iter::once(content_after).chain(noted.into_iter().flatten());
            self.pass_with(device, &source, tables, weights, fields, more.chain(exchange))
        }
    }

    /// Adds what the matrix is short of to rates a reference step.
    pub(super) fn rate(&self, device: &Device, fields: SeamFields<'_>) -> Result<Pass, GpuError> {
        self.pass(device, &self.passes.rate(), fields, [])
    }

    /// Adds the same to a vector of rates in shares of `factors`; held particles give to `given`.
    pub(super) fn combine(
        &self,
        device: &Device,
        fields: SeamFields<'_>,
        [factors, given]: [&Buffer; 2],
    ) -> Result<Pass, GpuError> {
        let given = self.passes.has_held().then_some(given);
        self.pass(
            device,
            &self.passes.combine(),
            fields,
            [Some(factors), given].into_iter().flatten(),
        )
    }

    /// Adds by how much that changes with a `change` of the state.
    pub(super) fn change(
        &self,
        device: &Device,
        fields: SeamFields<'_>,
        [factors, given, change]: [&Buffer; 3],
    ) -> Result<Pass, GpuError> {
        let given = self.passes.has_held().then_some(given);
        let more = [Some(factors), given, Some(change)].into_iter().flatten();
        self.pass(device, &self.passes.change(), fields, more)
    }

    fn pass<'a>(
        &'a self,
        device: &Device,
        source: &PassSource,
        fields: SeamFields<'a>,
        more: impl IntoIterator<Item = &'a Buffer>,
    ) -> Result<Pass, GpuError> {
        let tables = self.of_curves(fields.enthalpy);
        self.pass_with(device, source, tables, &self.weights, fields, more)
    }

    fn of_curves<'a>(&'a self, enthalpy: &'a Enthalpy) -> impl Iterator<Item = &'a Buffer> {
        enthalpy.curve().iter().chain([&self.of_segments])
    }

    fn pass_with<'a>(
        &'a self,
        device: &Device,
        source: &PassSource,
        tables: impl IntoIterator<Item = &'a Buffer>,
        weights: &'a Buffer,
        fields: SeamFields<'a>,
        more: impl IntoIterator<Item = &'a Buffer>,
    ) -> Result<Pass, GpuError> {
        let SeamFields { step_size, enthalpy, from, after } = fields;
        let mut buffers = vec![step_size];
        buffers.extend(tables);
        buffers.extend(self.rows.iter().chain([weights]));
        // Only a state in one part has several curves.
        buffers.extend([&enthalpy.parts(from)[0], after]);
        buffers.extend(more);
        device.pass(source, &buffers, self.count)
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let tables = [&self.of_segments, &self.weights].into_iter().chain(&self.of_phases);
        tables.chain(&self.written).chain(&self.rows).map(Buffer::bytes).sum()
    }
}

/// A vector for each segment: the temperature where it begins, as the sum of two words, and how it rises.
fn temperatures(curve: &HeatCurve) -> Vec<f64> {
    let of = |segment: &Segment| {
        let [temperature, rest] = two_words(segment.temperature);
        [temperature, rest, segment.warming, 0.0]
    };
    curve.segments().iter().flat_map(of).collect()
}

/// The same of the phases of a curve that potentials tell, with conductivities times `scale`: see
/// `shaders/seams/of_told.wgsl`.
fn temperatures_of_phases(curve: &HeatCurve, scale: f64) -> Vec<f64> {
    let segments = curve.segments();
    let (solid, liquid) = (&segments[0], &segments[segments.len() - 1]);
    let of = |segment: &Segment| {
        let [potential, rest] = two_words(segment.potential);
        let [temperature, of_temperature] = two_words(segment.temperature);
        [potential, rest, temperature, of_temperature]
    };
    let warming = |segment: &Segment| segment.warming / segment.slope;
    let conductivity = |segment: &Segment| curve.conductivity_of(segment).map(|k| scale * k);
    let of_phases = [solid, liquid];
    let [[of_solid, _], [of_liquid, _]] = of_phases.map(conductivity);
    let [rise, begins] = match segments {
        [_, melting, _] => [conductivity(melting)[1], melting.start],
        // Nothing melts.
        _ => [0.0; 2],
    };
    let [begins, of_begins] = two_words(begins);
    let mut table = of_phases.map(of).concat();
    table.extend([warming(solid), warming(liquid), of_solid, of_liquid]);
    table.extend([rise, begins, of_begins, 0.0]);
    table
}
