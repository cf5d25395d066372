//! Arithmetic expressions of a case file.
//!
//! A small parser of its own, for the usual rules of arithmetic: `-x^2` is -(x^2), `1e-3` is a
//! number, `^` binds to the right. The general-purpose crates looked at read `-x^2` as (-x)^2,
//! which would turn every Gaussian `exp(-x^2)` into nonsense without a word.

use glam::DVec3;

/// What a name stands for where an expression is used.
#[derive(Clone, Copy)]
pub(super) enum Meaning {
    /// A number.
    Constant(f64),
    /// x, y or z.
    Coordinate(usize),
    /// Time.
    Time,
}

/// Longest expression, in bytes: the tree of a longer one could exhaust the stack.
const MAX_LENGTH: usize = 1000;
/// Deepest nesting of parentheses and signs.
const MAX_DEPTH: usize = 60;

type Unary = fn(f64) -> f64;
type Binary = fn(f64, f64) -> f64;

const FUNCTIONS: [(&str, Unary); 20] = [
    ("abs", f64::abs),
    ("acos", f64::acos),
    ("asin", f64::asin),
    ("atan", f64::atan),
    ("ceil", f64::ceil),
    ("cos", f64::cos),
    ("cosh", f64::cosh),
    ("erf", libm::erf),
    ("erfc", libm::erfc),
    ("exp", f64::exp),
    ("floor", f64::floor),
    ("ln", f64::ln),
    ("log10", f64::log10),
    ("round", f64::round),
    ("sin", f64::sin),
    ("sinh", f64::sinh),
    ("sqrt", f64::sqrt),
    ("step", |x| if x < 0.0 { 0.0 } else { 1.0 }),
    ("tan", f64::tan),
    ("tanh", f64::tanh),
];

const FUNCTIONS_OF_TWO: [(&str, Binary); 3] =
    [("atan2", f64::atan2), ("max", f64::max), ("min", f64::min)];

/// Every function that an expression may call, for messages and the schema.
pub(super) fn function_names() -> String {
    let names = FUNCTIONS
        .iter()
        .map(|f| f.0)
        .chain(FUNCTIONS_OF_TWO.iter().map(|f| f.0));
    names.collect::<Vec<_>>().join(" ")
}

#[derive(Debug)]
enum Node {
    Constant(f64),
    Coordinate(usize),
    Time,
    Unary(Unary, Box<Node>),
    Binary(Binary, Box<Node>, Box<Node>),
}

impl Node {
    fn eval(&self, x: DVec3, t: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Coordinate(axis) => x[*axis],
            Self::Time => t,
            Self::Unary(function, a) => function(a.eval(x, t)),
            Self::Binary(function, a, b) => function(a.eval(x, t), b.eval(x, t)),
        }
    }

    fn unary(function: Unary, a: Node) -> Node {
        match a {
            Self::Constant(value) => Self::Constant(function(value)),
            a => Self::Unary(function, Box::new(a)),
        }
    }

    fn binary(function: Binary, a: Node, b: Node) -> Node {
        match (a, b) {
            (Self::Constant(a), Self::Constant(b)) => Self::Constant(function(a, b)),
            (a, b) => Self::Binary(function, Box::new(a), Box::new(b)),
        }
    }
}

/// A parsed expression.
#[derive(Debug)]
pub(super) struct Expression(Node);

impl Expression {
    /// Parses `text`; `meaning` says what a name stands for, or why it stands for nothing.
    pub(super) fn parse(
        text: &str,
        meaning: &dyn Fn(&str) -> Result<Meaning, String>,
    ) -> Result<Self, String> {
        if text.len() > MAX_LENGTH {
            return Err(format!("is longer than {MAX_LENGTH} characters"));
        }
        let mut parser = Parser {
            text,
            position: 0,
            depth: 0,
            meaning,
        };
        let node = parser.sum()?;
        match parser.peek() {
            None => Ok(Self(node)),
            Some(_) => Err(parser.unexpected("an operator")),
        }
    }

    /// The value at position `x` (m) and time `t` (s).
    pub(super) fn eval(&self, x: DVec3, t: f64) -> f64 {
        self.0.eval(x, t)
    }

    /// The value, if it depends on neither position nor time.
    pub(super) fn constant(&self) -> Option<f64> {
        match self.0 {
            Node::Constant(value) => Some(value),
            _ => None,
        }
    }
}

struct Parser<'a> {
    text: &'a str,
    position: usize,
    depth: usize,
    meaning: &'a dyn Fn(&str) -> Result<Meaning, String>,
}

impl Parser<'_> {
    /// The next character that is not a space.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.position..];
        self.position += rest.len() - rest.trim_start().len();
        self.text[self.position..].chars().next()
    }

    fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        if found {
            self.position += wanted.len_utf8();
        }
        found
    }

    /// Takes the bytes that `belongs` accepts.
    fn take_while(&mut self, belongs: impl Fn(u8) -> bool) -> &str {
        let rest = &self.text[self.position..];
        let length = rest.bytes().take_while(|&byte| belongs(byte)).count();
        self.position += length;
        &rest[..length]
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

    fn sum(&mut self) -> Result<Node, String> {
        let mut node = self.product()?;
        loop {
            if self.take('+') {
                node = Node::binary(|a, b| a + b, node, self.product()?);
            } else if self.take('-') {
                node = Node::binary(|a, b| a - b, node, self.product()?);
            } else {
                return Ok(node);
            }
        }
    }

    fn product(&mut self) -> Result<Node, String> {
        let mut node = self.signed()?;
        loop {
            if self.take('*') {
                node = Node::binary(|a, b| a * b, node, self.signed()?);
            } else if self.take('/') {
                node = Node::binary(|a, b| a / b, node, self.signed()?);
            } else {
                return Ok(node);
            }
        }
    }

    fn signed(&mut self) -> Result<Node, String> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(format!("is nested more than {MAX_DEPTH} deep"));
        }
        let node = if self.take('-') {
            Node::unary(|a| -a, self.signed()?)
        } else if self.take('+') {
            self.signed()?
        } else {
            self.power()?
        };
        self.depth -= 1;
        Ok(node)
    }

    fn power(&mut self) -> Result<Node, String> {
        let base = self.atom()?;
        if self.take('^') {
            return Ok(Node::binary(f64::powf, base, self.signed()?));
        }
        Ok(base)
    }

    fn atom(&mut self) -> Result<Node, String> {
        match self.peek() {
            Some('(') => {
                self.position += 1;
                let node = self.sum()?;
                self.close()?;
                Ok(node)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => self.name(),
            _ => Err(self.unexpected("a number, a name or \"(\"")),
        }
    }

    fn close(&mut self) -> Result<(), String> {
        if self.take(')') {
            Ok(())
        } else {
            Err(self.unexpected("\")\""))
        }
    }

    fn number(&mut self) -> Result<Node, String> {
        let start = self.position;
        self.take_while(|byte| byte.is_ascii_digit() || byte == b'.');
        let mantissa_end = self.position;
        if !self
            .take_while(|byte| byte == b'e' || byte == b'E')
            .is_empty()
        {
            self.take_while(|byte| byte == b'+' || byte == b'-');
            if self.take_while(|byte| byte.is_ascii_digit()).is_empty() {
                self.position = mantissa_end;
            }
        }
        let text = &self.text[start..self.position];
        text.parse()
            .map(Node::Constant)
            .map_err(|_| format!("\"{text}\" is not a number"))
    }

    fn name(&mut self) -> Result<Node, String> {
        let name = self
            .take_while(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
            .to_owned();
        let called = self.take('(');
        if let Some((_, function)) = FUNCTIONS.iter().find(|f| f.0 == name) {
            self.called(&name, called)?;
            let argument = self.sum()?;
            self.close()?;
            return Ok(Node::unary(*function, argument));
        }
        if let Some((_, function)) = FUNCTIONS_OF_TWO.iter().find(|f| f.0 == name) {
            self.called(&name, called)?;
            let first = self.sum()?;
            if !self.take(',') {
                return Err(self.unexpected("\",\""));
            }
            let second = self.sum()?;
            self.close()?;
            return Ok(Node::binary(*function, first, second));
        }
        if called {
            return Err(format!("unknown function \"{name}\""));
        }
        Ok(match (self.meaning)(&name)? {
            Meaning::Constant(value) => Node::Constant(value),
            Meaning::Coordinate(axis) => Node::Coordinate(axis),
            Meaning::Time => Node::Time,
        })
    }

    fn called(&self, name: &str, called: bool) -> Result<(), String> {
        if called {
            Ok(())
        } else {
            Err(format!("\"{name}\" is a function and needs \"(\""))
        }
    }
}
