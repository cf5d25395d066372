//! Smoothing kernels W(r) = sigma / H^dim w(r / H), of support radius H.
//!
//! Each kernel is one file with its [`Definition`]: the dimensionless shape `w(q)`, the shape of
//! its derivative `w'(q) / q`, and the factors sigma that make the integral 1. The WGSL twin of a
//! file is `shaders/kernel/<name>.wgsl`. A new kernel is those two files, and here a `mod` line, a
//! variant and its line in [`KernelKind::definition`].

mod cubic_spline;
mod hat;
mod lucy;
mod quintic_spline;
mod wendland_c2;
mod wendland_c4;
mod wendland_c6;

/// A pair counts as a neighbour below this fraction of the support radius.
///
/// Particles that sit exactly one support radius apart (every lattice with a whole support ratio)
/// would otherwise be neighbours or not by the rounding of their positions, differently in f32 and
/// f64. Every kernel but the hat vanishes there at least as (1 - q)^2, so a weight that this leaves
/// out is below 1e-12 of the largest; the hat's jump is put where its support ends.
pub const SUPPORT_MARGIN: f64 = 1.0 - 1e-6;

/// The mathematics of one kernel, in the dimensionless distance q = r / H in [0, 1).
pub struct Definition {
    /// The name in case files, and the stem of the shader file.
    pub name: &'static str,
    /// Shape w(q), for 0 <= q < 1.
    pub shape: fn(f64) -> f64,
    /// Shape of the derivative over the distance, w'(q) / q, never positive, for 0 <= q < 1.
    pub shape_dw_over_r: fn(f64) -> f64,
    /// sigma in 1-D, 2-D and 3-D; `None` where the kernel is not defined.
    pub sigma: [Option<f64>; 3],
    /// Whether w'(q) / q stays finite at q = 0, so that two particles may coincide.
    pub finite_at_zero: bool,
}

/// The kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum KernelKind {
    /// Cubic spline (Monaghan and Lattanzio 1985), H = 2 h in the classic notation.
    CubicSpline,
    /// Quintic spline (Morris, Fox and Zhu 1997), H = 3 h in the classic notation.
    QuinticSpline,
    /// Wendland's C2 function (Wendland 1995).
    WendlandC2,
    /// Wendland's C4 function (Wendland 1995).
    WendlandC4,
    /// Wendland's C6 function (Wendland 1995).
    WendlandC6,
    /// Lucy's kernel (Lucy 1977), the report's (183) and (184).
    Lucy,
    /// The hat (21), in 1-D alone.
    Hat,
}

impl KernelKind {
    /// Every kernel.
    pub const ALL: [Self; 7] = [
        Self::CubicSpline,
        Self::QuinticSpline,
        Self::WendlandC2,
        Self::WendlandC4,
        Self::WendlandC6,
        Self::Lucy,
        Self::Hat,
    ];

    /// The kernel's mathematics.
    pub fn definition(self) -> &'static Definition {
        match self {
            Self::CubicSpline => &cubic_spline::DEFINITION,
            Self::QuinticSpline => &quintic_spline::DEFINITION,
            Self::WendlandC2 => &wendland_c2::DEFINITION,
            Self::WendlandC4 => &wendland_c4::DEFINITION,
            Self::WendlandC6 => &wendland_c6::DEFINITION,
            Self::Lucy => &lucy::DEFINITION,
            Self::Hat => &hat::DEFINITION,
        }
    }

    /// The name in case files, and the stem of the shader file.
    pub fn name(self) -> &'static str {
        self.definition().name
    }

    /// Whether the kernel is defined in `dimension` (1, 2 or 3).
    pub fn is_defined_in(self, dimension: usize) -> bool {
        self.definition().sigma[dimension - 1].is_some()
    }
}

/// A kernel of given dimension and support radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    kind: KernelKind,
    dimension: usize,
    support_radius: f64,
    w_scale: f64,
    dw_over_r_scale: f64,
}

impl Kernel {
    /// The kernel `kind` in `dimension` (1, 2 or 3) with support radius H (m, positive); `None`
    /// where the kernel is not defined in that dimension.
    pub fn new(kind: KernelKind, dimension: usize, support_radius: f64) -> Option<Self> {
        let sigma = kind.definition().sigma[dimension - 1]?;
        let w_scale = sigma / support_radius.powi(dimension as i32);
        let dw_over_r_scale = w_scale / (support_radius * support_radius);
        Some(Self { kind, dimension, support_radius, w_scale, dw_over_r_scale })
    }

    /// The same kernel with W and W' multiplied by `factor`: a wrong normalisation, for the negative
    /// controls of tests.
    #[must_use]
    pub fn with_factor(self, factor: f64) -> Self {
        let [w_scale, dw_over_r_scale] = [self.w_scale, self.dw_over_r_scale].map(|s| s * factor);
        Self { w_scale, dw_over_r_scale, ..self }
    }

    /// Which kernel.
    pub fn kind(&self) -> KernelKind {
        self.kind
    }

    /// 1, 2 or 3.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Support radius H, m.
    pub fn support_radius(&self) -> f64 {
        self.support_radius
    }

    /// Pairs nearer than this are neighbours: [`SUPPORT_MARGIN`] H, m.
    pub fn cutoff(&self) -> f64 {
        SUPPORT_MARGIN * self.support_radius
    }

    /// W(r), m^-dim; 0 at and past the support radius.
    pub fn w(&self, r: f64) -> f64 {
        let q = r / self.support_radius;
        if q < 1.0 { self.w_scale * (self.kind.definition().shape)(q) } else { 0.0 }
    }

    /// W'(r) / r, m^-(dim + 2), never positive; 0 at and past the support radius. This is the
    /// report's F, (74).
    pub fn dw_over_r(&self, r: f64) -> f64 {
        let q = r / self.support_radius;
        if q < 1.0 {
            self.dw_over_r_scale * (self.kind.definition().shape_dw_over_r)(q)
        } else {
            0.0
        }
    }

    /// The factor sigma / H^(dim + 2) that turns the dimensionless w'(q)/q into W'(r)/r.
    pub fn dw_over_r_scale(&self) -> f64 {
        self.dw_over_r_scale
    }
}

#[cfg(test)]
mod tests;
