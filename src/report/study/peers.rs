//! Points of other programs that solve the same problem.

use serde::{Deserialize, Serialize};

use super::Spread;

/// Version of the layout of a file of peers.
pub const PEERS_VERSION: u32 = 1;

/// What other programs took for the same problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Peers {
    /// [`PEERS_VERSION`].
    pub peers_version: u32,
    /// Where they ran, in words.
    pub machine: String,
    /// What was measured.
    pub points: Vec<PeerPoint>,
}

/// One program at one setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PeerPoint {
    /// The program and the method.
    pub tool: String,
    /// The program's version.
    #[serde(default)]
    pub version: String,
    /// The command that ran it.
    #[serde(default)]
    pub command: String,
    /// What was set, in short.
    #[serde(default)]
    pub setting: String,
    /// How many particles, nodes or cells.
    #[serde(default)]
    pub particles: Option<u64>,
    /// Set-up in every run, s.
    pub setup_s: Vec<f64>,
    /// The solution in every run, s.
    pub solve_s: Vec<f64>,
    /// Relative L2 of the error.
    pub l2_relative: f64,
    /// What the error is against.
    #[serde(default)]
    pub against: String,
}

impl Peers {
    /// Reads a file of peers.
    ///
    /// # Errors
    /// What is wrong and where, in words.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut json = serde_json::Deserializer::from_str(text);
        let peers: Self = serde_path_to_error::deserialize(&mut json).map_err(|error| {
            let path = error.path().to_string();
            format!("{path}: {}", error.into_inner())
        })?;
        json.end().map_err(|error| error.to_string())?;
        if peers.peers_version != PEERS_VERSION {
            let found = peers.peers_version;
            return Err(format!("peers_version: is {found}, must be {PEERS_VERSION}"));
        }
        for (index, point) in peers.points.iter().enumerate() {
            point.check().map_err(|why| format!("points[{index}].{why}"))?;
        }
        Ok(peers)
    }
}

impl PeerPoint {
    fn check(&self) -> Result<(), String> {
        let is_time = |time: &f64| time.is_finite() && *time >= 0.0;
        for (name, times) in [("setup_s", &self.setup_s), ("solve_s", &self.solve_s)] {
            if times.is_empty() || !times.iter().all(is_time) {
                return Err(format!("{name}: must be a list of times, at least one"));
            }
        }
        if !(self.l2_relative.is_finite() && self.l2_relative >= 0.0) {
            return Err("l2_relative: must be 0 or above".to_owned());
        }
        Ok(())
    }

    /// The medians of set-up and solution together, s.
    pub fn total_s(&self) -> f64 {
        let median = |times: &[f64]| Spread::of(times.iter().copied()).median;
        median(&self.setup_s) + median(&self.solve_s)
    }

    /// What it is, in short.
    pub fn name(&self) -> String {
        let parts = [&self.tool, &self.version, &self.setting];
        let given = parts.into_iter().filter(|part| !part.is_empty());
        given.map(String::as_str).collect::<Vec<_>>().join(" ")
    }
}
