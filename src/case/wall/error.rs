//! What can be wrong with walls and surfaces.

/// What is wrong with a wall or a surface, in one line that names the JSON path.
#[derive(Debug, thiserror::Error)]
pub enum WallError {
    /// A list of faces without any.
    #[error("{path}: names no face")]
    NoFace {
        /// Path of the list.
        path: String,
    },
    /// Two walls that each cover all of a face.
    #[error("{path}: {first} covers all of {face} already; give one of the two a \"where\"")]
    TwoWalls {
        /// Path of the face in the later wall.
        path: String,
        /// The earlier wall's path.
        first: String,
        /// Name of the face.
        face: String,
    },
    /// Two walls of which each covers the same part of a face.
    #[error("{second}: two kinds on one patch: {first} covers the point {point} of {face} too")]
    TwoKinds {
        /// The earlier wall's path.
        first: String,
        /// The later wall's path.
        second: String,
        /// Name of the face.
        face: String,
        /// A point of both.
        point: String,
    },
    /// A part of a face that no particle is next to.
    #[error(
        "{path}: lies outside its face {face}, {axis} = {coordinate} m: no particle has its foot \
         in it"
    )]
    OutsideFace {
        /// Path of the shape.
        path: String,
        /// Name of the face.
        face: String,
        /// Name of the axis across it.
        axis: &'static str,
        /// Where it lies on that axis, m.
        coordinate: f64,
    },
    /// A transfer coefficient below zero somewhere.
    #[error("{path}: is {value} at {point}, must be zero or positive")]
    NegativeCoefficient {
        /// The coefficient's path.
        path: String,
        /// Its value there, m/s.
        value: f64,
        /// The point.
        point: String,
    },
    /// A body thinner than the support between its walls.
    #[error(
        "kernel.support_ratio: the support radius of {support_radius} m is more than the {extent} \
         m along {axis}, where {wall} is; {}", widest(*.most)
    )]
    TooThin {
        /// Support radius, m.
        support_radius: f64,
        /// Length of the axis, m.
        extent: f64,
        /// Name of the axis.
        axis: &'static str,
        /// The wall's path.
        wall: String,
        /// The largest support ratio that fits; at 1 and below none does.
        most: f64,
    },
    /// A particle that its own ghost would coincide with.
    #[error(
        "{path}: the particle at {point} lies on {face}, where its mirror image would coincide \
         with it; a wall needs particles half a spacing away"
    )]
    OnWall {
        /// The wall's path.
        path: String,
        /// Name of the face.
        face: String,
        /// The particle's position.
        point: String,
    },
    /// A kind of wall that a surface cannot be.
    #[error("{path}: a surface has flux or convection, not {kind}; {advice}")]
    NotOnSurface {
        /// Path of the kind.
        path: String,
        /// Name of the kind.
        kind: &'static str,
        /// What to do instead.
        advice: &'static str,
    },
    /// A surface far from every particle.
    #[error("{path}: no particle lies within the support radius of {support_radius} m of {part}")]
    NothingNear {
        /// The surface's path.
        path: String,
        /// Support radius, m.
        support_radius: f64,
        /// What it is too far from.
        part: &'static str,
    },
}

fn widest(most: f64) -> String {
    if most > 1.0 {
        return format!("the largest support_ratio allowed is {most}");
    }
    "no support_ratio fits an axis of at most one spacing".to_owned()
}
