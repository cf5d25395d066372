//! Expressions: the rules of arithmetic, and what is refused.

use glam::DVec3;

use crate::case::expression::{Expression, Meaning, function_names};

fn value(text: &str) -> Result<f64, String> {
    let meaning = |name: &str| match name {
        "x" => Ok(Meaning::Coordinate(0)),
        "t" => Ok(Meaning::Time),
        // Names that begin like a function or a number.
        "max_x" | "e1" => Ok(Meaning::Constant(1.0)),
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
        ("2*-x^2", -18.0),
        ("2/-x^2*9", -2.0),
        ("2^-x^2*512", 1.0),
        ("-x^2^-t", -(3.0_f64.powf(0.25))),
        ("-(x)^2 - -t", -7.0),
        ("-sin(x)^2", -(3.0_f64.sin().powi(2))),
        ("min(1, max(-x^2, max(min(-2, t), -4)))", -2.0),
        ("6*x/6*x - 5. + t", 6.0),
        ("1e-20 + 1 - 1", 0.0),
        ("1e200*1e200/1e200", f64::INFINITY),
        ("max_x + e1", 2.0),
        ("sin(pi/2) + erfc(0) + erf(0)", 2.0),
    ] {
        let found = value(text).expect(text);
        let equal = found == expected || (found - expected).abs() < 1e-14;
        assert!(equal, "{text}: {found}");
    }
}

#[test]
fn every_listed_function_can_be_called() {
    for name in function_names().split(' ') {
        let called = [format!("{name}(t/4)"), format!("{name}(t/4, x)")];
        let values = called.map(|text| value(&text));
        assert!(values.iter().filter(|value| value.is_ok()).count() == 1, "{name}: {values:?}");
    }
}

#[test]
fn only_what_depends_on_nothing_is_constant() {
    let meaning = |_: &str| Ok(Meaning::Time);
    for (text, expected) in [("2*sin(1)^2", true), ("0*t", false)] {
        let expression = Expression::parse(text, &meaning).expect(text);
        assert_eq!(expression.constant().is_some(), expected, "{text}");
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
        ("sin(1, 2)", "expected \")\", found \",\" at character 6"),
        ("min(1, 2, 3)", "expected \")\", found \",\""),
        ("PI", "unknown name \"PI\""),
        ("2*e", "unknown name \"e\""),
        ("signum(1)", "unknown function \"signum\""),
        ("{x}", "found \"{\" at character 1"),
        ("2^", "at the end"),
        ("()", "expected a number, a name or \"(\", found \")\""),
        ("1 € 2", "found \"€\""),
    ] {
        let reason = value(text).expect_err(text);
        assert!(reason.contains(part), "{text}: {reason}");
    }
    assert!(value(&"(".repeat(500)).expect_err("deep").contains("nested"));
    assert!(value(&"-".repeat(500)).expect_err("deep").contains("nested"));
    assert!(value(&"1+".repeat(501)).expect_err("long").contains("longer"));
}
