use super::*;

fn layer(to: f64, conductivity: f64, resistance: f64) -> Layer {
    Layer { to, conductivity, resistance }
}

/// Resistances 0.5, 0.25 between, 1, 0.25 and 2 (which does not count): 2 in all.
fn layers() -> LayersSetup {
    let layers = vec![layer(1.0, 2.0, 0.25), layer(1.5, 0.5, 0.0), layer(2.0, 2.0, 2.0)];
    LayersSetup { axis: 2, from: 0.0, left: 500.0, right: 300.0, layers }
}

fn at(place: f64) -> DVec3 {
    DVec3::new(7.0, -3.0, place)
}

#[test]
fn known_values() {
    let wall = Layers::new(layers());
    close(wall.flux(), 100.0, 1e-12);
    for (place, expected) in [
        (0.0, 500.0),
        (0.5, 475.0),
        (1.0, 450.0),
        (1.0 + 1e-15, 425.0),
        (1.25, 375.0),
        (1.5, 325.0),
        (1.75, 312.5),
        (2.0, 300.0),
    ] {
        close(wall.at(at(place)), expected, 1e-11);
    }
    assert_eq!([-1.0, 0.0, 2.0, 9.0].map(|x| wall.at(at(x))), [500.0, 500.0, 300.0, 300.0]);
    let solution = Solution::Layers(wall.clone());
    assert_eq!([0.0, 1e9].map(|t| solution.at(at(1.2), t)), [wall.at(at(1.2)); 2]);
}

#[test]
fn one_flux_goes_through_all_layers() {
    let setup = layers();
    let wall = Layers::new(setup.clone());
    let slope = |place: f64| (wall.at(at(place + 1e-3)) - wall.at(at(place - 1e-3))) / 2e-3;
    let mut lower = setup.from;
    for layer in &setup.layers {
        for share in [0.2, 0.5, 0.8] {
            let place = lower + share * (layer.to - lower);
            close(-layer.conductivity * slope(place), wall.flux(), 1e-8);
        }
        lower = layer.to;
    }
    let step = |place: f64| wall.at(at(place - 1e-13)) - wall.at(at(place + 1e-13));
    close(step(1.0), 0.25 * wall.flux(), 1e-9);
    close(step(1.5), 0.0, 1e-9);
    close(step(2.0), 0.0, 1e-9);
    // Negative control: without the contact resistance more flows.
    let mut perfect = setup;
    perfect.layers[0].resistance = 0.0;
    assert!(Layers::new(perfect).flux() > 1.1 * wall.flux());
}

#[test]
fn one_layer_is_a_line() {
    for layers in [
        vec![layer(2.0, 0.7, 0.0)],
        vec![layer(0.3, 0.7, 0.0), layer(0.4, 0.7, 0.0), layer(2.0, 0.7, 0.0)],
    ] {
        let wall = Layers::new(LayersSetup { axis: 2, from: -1.0, left: 2.0, right: 5.0, layers });
        close(wall.flux(), -0.7, 1e-15);
        for place in [-0.9, 0.2, 0.35, 1.9] {
            close(wall.at(at(place)), 3.0 + place, 1e-14);
        }
    }
}
