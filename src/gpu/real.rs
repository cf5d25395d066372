//! The scalar type of a shader.

/// What `real` means in a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Real {
    /// 32 bits.
    F32,
    /// 64 bits; the adapter must have the feature.
    F64,
}

impl Real {
    /// Both.
    pub const ALL: [Self; 2] = [Self::F32, Self::F64];

    /// Its WGSL name.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    /// Size and alignment, bytes.
    pub fn size(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The spacing of the numbers just above 1.
    pub fn epsilon(self) -> f64 {
        match self {
            Self::F32 => f64::from(f32::EPSILON),
            Self::F64 => f64::EPSILON,
        }
    }

    /// The largest finite number.
    pub fn largest(self) -> f64 {
        match self {
            Self::F32 => f64::from(f32::MAX),
            Self::F64 => f64::MAX,
        }
    }

    /// A literal of this type with exactly this value, rounded to the type.
    pub fn literal(self, value: f64) -> String {
        match self {
            Self::F32 => format!("{:?}f", value as f32),
            Self::F64 => format!("{value:?}lf"),
        }
    }

    /// The values, rounded to this type, as a device holds them.
    pub fn to_bytes(self, values: &[f64]) -> Vec<u8> {
        match self {
            Self::F32 => values.iter().flat_map(|&value| (value as f32).to_ne_bytes()).collect(),
            Self::F64 => bytemuck::cast_slice(values).to_vec(),
        }
    }

    /// The inverse of [`Real::to_bytes`].
    pub fn from_bytes(self, bytes: &[u8]) -> Vec<f64> {
        match self {
            Self::F32 => bytes
                .chunks_exact(4)
                .map(|b| f64::from(f32::from_ne_bytes([b[0], b[1], b[2], b[3]])))
                .collect(),
            Self::F64 => bytemuck::pod_collect_to_vec(bytes),
        }
    }
}
