//! Expressions: the rules of arithmetic, and what is refused.

use glam::DVec3;

use crate::case::expression::{Expression, Meaning};

fn value(text: &str) -> Result<f64, String> {
    let meaning = |name: &str| match name {
        "x" => Ok(Meaning::Coordinate(0)),
        "t" => Ok(Meaning::Time),
        "pi" => Ok(Meaning::Constant(std::f64::consts::PI)),
        _ => Err(format!("unknown name \"{name}\"")),
    };
    Expression::parse(text, &meaning).map(|e| e.eval(DVec3::new(3.0, 0.0, 0.0), 2.0))
}

#[test]
fn arithmetic_follows_the_usual_rules() {
    for (text, expected) in [
        ("1e-3", 1e-3),
        ("1.5E+2 - .5", 149.5),
        ("-x^2", -9.0),
        ("2^-1", 0.5),
        ("2^3^2", 512.0),
        ("8/4/2", 1.0),
        ("10-4-3", 3.0),
        ("2*-3", -6.0),
        ("-(1+2)*x", -9.0),
        ("--x", 3.0),
        ("exp(-x^2/(4*t))", (-9.0_f64 / 8.0).exp()),
        (" sqrt( 16 ) + abs(-2)", 6.0),
        ("atan2(1, 1)*4", std::f64::consts::PI),
        ("min(x, t) + max(x,t)", 5.0),
        ("step(x-3) + step(t-3)", 1.0),
        ("sin(pi/2) + erfc(0) + erf(0)", 2.0),
    ] {
        let found = value(text).expect(text);
        assert!((found - expected).abs() < 1e-14, "{text}: {found}");
    }
}

#[test]
fn nonsense_is_refused() {
    for (text, part) in [
        ("", "at the end"),
        ("1 +", "at the end"),
        ("(1", "expected \")\""),
        ("1)", "expected an operator, found \")\" at character 2"),
        ("2 x", "expected an operator"),
        ("2exp(1)", "expected an operator"),
        ("1.2.3", "\"1.2.3\" is not a number"),
        ("sin x", "needs \"(\""),
        ("foo(1)", "unknown function \"foo\""),
        ("foo", "unknown name \"foo\""),
        ("min(1)", "expected \",\""),
        ("1 € 2", "found \"€\""),
    ] {
        let reason = value(text).expect_err(text);
        assert!(reason.contains(part), "{text}: {reason}");
    }
    assert!(
        value(&"(".repeat(500))
            .expect_err("deep")
            .contains("nested")
    );
    assert!(
        value(&"-".repeat(500))
            .expect_err("deep")
            .contains("nested")
    );
    assert!(
        value(&"1+".repeat(501))
            .expect_err("long")
            .contains("longer")
    );
}
