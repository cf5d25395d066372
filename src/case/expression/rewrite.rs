//! From the usual notation to one that the expression library cannot mistake.
//!
//! The library applies a sign before any operator: `-x^2` would be (-x)^2, which turns every
//! Gaussian `exp(-x^2)` into nonsense without a word. It takes `2^3^2` from the left, loses a
//! parenthesis in `max(1, max(2, 3))`, and reads a name such as `max_t` as the function `max`.
//! So what a sign or `^` applies to is put in parentheses here, `-x^2` becoming `-({x}^(2))`;
//! `max(a, b)` becomes `((a)max(b))`; and a name becomes a number or a variable in braces.
//!
//! Only sound text passes, so that mistakes are reported by their place in what the user wrote.

use exmex::MatchLiteral;

use super::{FUNCTIONS, FUNCTIONS_OF_TWO, Literal, Meaning, VARIABLES};

/// Longest expression, in bytes: the library's work grows with the square of the length.
const MAX_LENGTH: usize = 1000;
/// Deepest nesting of parentheses, signs and powers; deeper is a slip of the keyboard.
const MAX_DEPTH: usize = 60;

/// The text for the library; `meaning` says what a name stands for.
pub(super) fn rewrite(
    text: &str,
    meaning: &dyn Fn(&str) -> Result<Meaning, String>,
) -> Result<String, String> {
    if text.len() > MAX_LENGTH {
        return Err(format!("is longer than {MAX_LENGTH} characters"));
    }
    let mut rewriter =
        Rewriter { text, position: 0, output: String::new(), open: Vec::new(), meaning };
    let mut operand_next = true;
    while operand_next || rewriter.peek().is_some() {
        operand_next = if operand_next { rewriter.operand()? } else { rewriter.operator()? };
        if rewriter.open.len() >= MAX_DEPTH {
            return Err(format!("is nested more than {MAX_DEPTH} deep"));
        }
    }
    rewriter.end_factors();
    match rewriter.open.last() {
        None => Ok(rewriter.output),
        Some(_) => Err(rewriter.misplaced()),
    }
}

/// A parenthesis that is open in the output.
enum Open<'a> {
    /// One of the user's.
    Group,
    /// Around the first argument of this function of two.
    First(&'a str),
    /// Around its second argument.
    Second,
    /// Around what a sign or `^` applies to.
    Factor,
}

struct Rewriter<'a> {
    text: &'a str,
    position: usize,
    output: String,
    open: Vec<Open<'a>>,
    meaning: &'a dyn Fn(&str) -> Result<Meaning, String>,
}

impl<'a> Rewriter<'a> {
    /// The next character that is not a space.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.position..];
        self.position += rest.len() - rest.trim_start().len();
        self.text[self.position..].chars().next()
    }

    /// Passes an ASCII character of the text, writing `output` for it.
    fn pass(&mut self, output: &str) {
        self.position += 1;
        self.output += output;
    }

    /// Rewrites what begins an operand; true if the operand is still to come.
    fn operand(&mut self) -> Result<bool, String> {
        match self.peek() {
            Some(sign @ ('+' | '-')) => {
                self.pass(if sign == '+' { "+(" } else { "-(" });
                self.open.push(Open::Factor);
                Ok(true)
            }
            Some('(') => {
                self.pass("(");
                self.open.push(Open::Group);
                Ok(true)
            }
            Some(c) if c.is_ascii_alphabetic() => self.name(),
            _ => self.number(),
        }
    }

    fn number(&mut self) -> Result<bool, String> {
        let Some(literal) = Literal::is_literal(&self.text[self.position..]) else {
            return Err(self.unexpected("a number, a name or \"(\""));
        };
        if literal.parse::<f64>().is_err() {
            return Err(format!("\"{literal}\" is not a number"));
        }
        self.position += literal.len();
        self.output += literal;
        Ok(false)
    }

    fn name(&mut self) -> Result<bool, String> {
        let rest = &self.text[self.position..];
        let belongs = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
        let name = &rest[..rest.bytes().take_while(belongs).count()];
        self.position += name.len();
        let called = self.peek() == Some('(');
        let (begin, open) = if FUNCTIONS.contains(&name) {
            (format!("{name}("), Open::Group)
        } else if FUNCTIONS_OF_TWO.contains(&name) {
            ("((".to_owned(), Open::First(name))
        } else if called {
            return Err(format!("unknown function \"{name}\""));
        } else {
            self.output += &match (self.meaning)(name)? {
                Meaning::Constant(value) => format!("({value:?})"),
                Meaning::Coordinate(axis) => format!("{{{}}}", VARIABLES[1 + axis]),
                Meaning::Time => format!("{{{}}}", VARIABLES[0]),
            };
            return Ok(false);
        };
        if !called {
            return Err(format!("\"{name}\" is a function and needs \"(\""));
        }
        self.pass(&begin);
        self.open.push(open);
        Ok(true)
    }

    /// Rewrites what follows an operand; true if an operand must come next.
    fn operator(&mut self) -> Result<bool, String> {
        let next = self.peek();
        if next == Some('^') {
            self.pass("^(");
            self.open.push(Open::Factor);
            return Ok(true);
        }
        self.end_factors();
        match (next, self.open.last()) {
            (Some('+'), _) => self.pass("+"),
            (Some('-'), _) => self.pass("-"),
            (Some('*'), _) => self.pass("*"),
            (Some('/'), _) => self.pass("/"),
            (Some(','), Some(&Open::First(name))) => {
                self.pass(&format!("){name}("));
                self.open.pop();
                self.open.push(Open::Second);
            }
            (Some(')'), Some(Open::Group)) => return Ok(self.close(")")),
            (Some(')'), Some(Open::Second)) => return Ok(self.close("))")),
            _ => return Err(self.misplaced()),
        }
        Ok(true)
    }

    /// Closes the innermost parenthesis: no operand must come next.
    fn close(&mut self, output: &str) -> bool {
        self.pass(output);
        self.open.pop();
        false
    }

    /// Closes the factors that end here: each reaches to the next operator weaker than `^`.
    fn end_factors(&mut self) {
        while let Some(Open::Factor) = self.open.last() {
            self.open.pop();
            self.output.push(')');
        }
    }

    /// The error of finding neither an operator nor what the innermost parenthesis needs.
    fn misplaced(&mut self) -> String {
        self.unexpected(match self.open.last() {
            None => "an operator",
            Some(Open::First(_)) => "\",\"",
            Some(_) => "\")\"",
        })
    }

    fn unexpected(&mut self, wanted: &str) -> String {
        match self.peek() {
            Some(found) => {
                let place = self.text[..self.position].chars().count() + 1;
                format!("expected {wanted}, found \"{found}\" at character {place}")
            }
            None => format!("expected {wanted} at the end"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_library_is_told_what_applies_to_what() {
        let meaning = |name: &str| match name {
            "x" => Ok(Meaning::Coordinate(0)),
            "t" => Ok(Meaning::Time),
            _ => Ok(Meaning::Constant(1e-7)),
        };
        for (text, expected) in [
            ("x - t*2.5e-3", "{x}-{t}*2.5e-3"),
            ("-x^2", "-({x}^(2))"),
            ("2*-x^2 + t", "2*-({x}^(2))+{t}"),
            ("-x^2^-t/2", "-({x}^(2^(-({t}))))/2"),
            ("-(x)^2", "-(({x})^(2))"),
            ("-sin(-x)^2", "-(sin(-({x}))^(2))"),
            ("max(-x, max(t, 1))", "((-({x}))max((({t})max(1))))"),
            ("max_t + e", "(1e-7)+(1e-7)"),
        ] {
            assert_eq!(rewrite(text, &meaning).as_deref(), Ok(expected), "{text}");
        }
    }
}
