//! Layers on top of each other.

use glam::DVec3;

/// One of several layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Coordinate of its upper face, m.
    pub to: f64,
    /// Conductivity k.
    pub conductivity: f64,
    /// Contact resistance between it and the next layer, m2 K/W, not negative; that of the last
    /// layer does not count.
    pub resistance: f64,
}

/// What a [`Layers`] is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct LayersSetup {
    /// The axis across the layers: 0, 1 or 2.
    pub axis: usize,
    /// Coordinate of the lower face of the first layer, m.
    pub from: f64,
    /// Held value of this face.
    pub left: f64,
    /// Held value of the upper face of the last layer.
    pub right: f64,
    /// At least one, in ascending order.
    pub layers: Vec<Layer>,
}

/// The steady state of layers between two held faces, at any t (Carslaw and Jaeger 1959, 3.2):
/// one flux q = (left - right) / (sum of thickness / k + sum of contact resistances) goes through
/// all of them; the value falls by q thickness / k across a layer and by q resistance between two.
///
/// At a plane between two layers it has the value of the lower one, outside that of the nearer
/// face.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    setup: LayersSetup,
    flux: f64,
    /// Coordinate and value of the lower face of every layer.
    starts: Vec<[f64; 2]>,
}

impl Layers {
    /// Finds the flux and the values between the layers.
    pub fn new(setup: LayersSetup) -> Self {
        let last = setup.layers.len().saturating_sub(1);
        let mut lower = setup.from;
        let mut resistances = Vec::new();
        for (index, layer) in setup.layers.iter().enumerate() {
            let contact = if index < last { layer.resistance } else { 0.0 };
            resistances.push([lower, (layer.to - lower) / layer.conductivity + contact]);
            lower = layer.to;
        }
        let total: f64 = resistances.iter().map(|[_, resistance]| resistance).sum();
        let flux = (setup.left - setup.right) / total;
        let mut before = 0.0;
        let start = |[lower, resistance]: [f64; 2]| {
            let value = setup.left - flux * before;
            before += resistance;
            [lower, value]
        };
        let starts = resistances.into_iter().map(start).collect();
        Self { setup, flux, starts }
    }

    /// What flows along the axis through a unit area, W/m2 or value x m/s.
    pub fn flux(&self) -> f64 {
        self.flux
    }

    /// The value at position `x` (m).
    pub fn at(&self, x: DVec3) -> f64 {
        let place = x[self.setup.axis];
        if place <= self.setup.from {
            return self.setup.left;
        }
        let layers = self.setup.layers.iter().zip(&self.starts);
        let last = self.setup.layers.last().map_or(self.setup.from, |layer| layer.to);
        match layers.into_iter().find(|(layer, _)| place <= layer.to) {
            Some((layer, [lower, value])) if place < last => {
                value - self.flux * (place - lower) / layer.conductivity
            }
            _ => self.setup.right,
        }
    }
}
