//! Numbers as text for people: grouped thousands, significant digits, units.

/// A count with its thousands grouped by spaces: `1 000 000`.
pub fn grouped(count: u64) -> String {
    if count < 1000 {
        return count.to_string();
    }
    format!("{} {:03}", grouped(count / 1000), count % 1000)
}

/// A number to `digits` significant digits, without trailing zeros: plain between 1e-3 and 1e6,
/// with an exponent elsewhere. `not finite` for what is no number.
pub fn significant(number: f64, digits: usize) -> String {
    if !number.is_finite() {
        return "not finite".to_owned();
    }
    if number == 0.0 {
        return "0".to_owned();
    }
    // Rounded first, so that 999.9996 counts as the 1000 that it is printed as.
    let scientific = format!("{number:.*e}", digits.saturating_sub(1));
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-3..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        return trimmed(&format!("{number:.decimals$}")).to_owned();
    }
    format!("{}e{exponent}", trimmed(mantissa))
}

/// Without the zeros that end a decimal fraction.
fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// Simulated time in seconds, and in the longest unit of year (365 days), day or hour that it
/// fills: `63 072 000 s (2 years)`.
pub fn simulated_time(seconds: f64) -> String {
    const UNITS: [(f64, &str); 3] = [(31_536_000.0, "year"), (86_400.0, "day"), (3600.0, "hour")];
    let whole = seconds.fract() == 0.0 && (1e4..1e15).contains(&seconds);
    let plain = if whole { grouped(seconds as u64) } else { significant(seconds, 6) };
    let Some((length, unit)) = UNITS.into_iter().find(|(length, _)| seconds >= *length) else {
        return format!("{plain} s");
    };
    let number = significant(seconds / length, 4);
    let plural = if number == "1" { "" } else { "s" };
    format!("{plain} s ({number} {unit}{plural})")
}

/// Wall-clock time: `3.21 s`, `45.6 ms`, `5 min 12 s`, `2 h 05 min`.
pub fn wall_time(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "not finite".to_owned();
    }
    let whole = seconds.round() as u64;
    match seconds {
        s if s < 0.9995 => format!("{} ms", significant(s * 1e3, 3)),
        s if s < 119.5 => format!("{} s", significant(s, 3)),
        s if s < 7199.5 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

/// Memory in decimal units: `24 MB`.
pub fn bytes(count: u64) -> String {
    const UNITS: [(u64, &str); 3] = [(1_000_000_000, "GB"), (1_000_000, "MB"), (1000, "kB")];
    match UNITS.into_iter().find(|(size, _)| count >= *size) {
        Some((size, unit)) => format!("{} {unit}", significant(count as f64 / size as f64, 3)),
        None => format!("{count} B"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_grouped() {
        let text = [0, 999, 1000, 1_234_567, 100_000_000].map(grouped);
        assert_eq!(text, ["0", "999", "1 000", "1 234 567", "100 000 000"]);
    }

    #[test]
    fn numbers_keep_their_significant_digits() {
        for (number, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.130_149, "0.1301"),
            (-0.001_234_56, "-0.001235"),
            (999.999_6, "1000"),
            (123_456.0, "123456"),
            (1_234_567.0, "1.235e6"),
            (9.999_99e-4, "0.001"),
            (1.5e-15, "1.5e-15"),
            (f64::NAN, "not finite"),
        ] {
            assert_eq!(significant(number, 4), text);
        }
    }

    #[test]
    fn times_and_sizes_carry_their_unit() {
        assert_eq!(simulated_time(63_072_000.0), "63 072 000 s (2 years)");
        assert_eq!(simulated_time(86_400.0), "86 400 s (1 day)");
        assert_eq!(simulated_time(0.25), "0.25 s");
        let wall = [0.0456, 3.214, 119.6, 312.4, 7500.0].map(wall_time);
        assert_eq!(wall, ["45.6 ms", "3.21 s", "2 min 00 s", "5 min 12 s", "2 h 05 min"]);
        assert_eq!([12, 24_000_000, 1_500_000_000].map(bytes), ["12 B", "24 MB", "1.5 GB"]);
    }
}
