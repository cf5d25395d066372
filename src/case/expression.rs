//! Arithmetic expressions of a case file.
//!
//! The `exmex` crate parses and evaluates them, from the text that [`rewrite`] makes of the usual
//! notation.

mod rewrite;

use exmex::{
    BinOp, Express, FlatEx, FloatOpsFactory, MakeOperators, MatchLiteral, Operator,
    literal_matcher_from_pattern,
};
use glam::DVec3;

/// What a name stands for where an expression is used.
#[derive(Clone, Copy)]
pub(super) enum Meaning {
    /// A finite number.
    Constant(f64),
    /// x, y or z.
    Coordinate(usize),
    /// Time.
    Time,
}

const FUNCTIONS: [&str; 20] = [
    "abs", "acos", "asin", "atan", "ceil", "cos", "cosh", "erf", "erfc", "exp", "floor", "ln",
    "log10", "round", "sin", "sinh", "sqrt", "step", "tan", "tanh",
];

const FUNCTIONS_OF_TWO: [&str; 3] = ["atan2", "max", "min"];

/// Time and the coordinates, in alphabetical order: the library takes their values in that order.
const VARIABLES: [&str; 4] = ["t", "x", "y", "z"];

/// Index of time among the [`VARIABLES`].
const TIME: usize = 0;

/// Every function that an expression may call, for messages and the schema.
pub(super) fn function_names() -> String {
    [FUNCTIONS.as_slice(), &FUNCTIONS_OF_TWO].concat().join(" ")
}

// The library's own literals know no exponent. What is no number after all, such as 1.2.3, is
// taken in one piece, to be refused in one piece.
literal_matcher_from_pattern!(Literal, r"^[0-9.]+([eE]+[+-]*[0-9]+)?");

/// The operators of an expression: the usual ones, and the functions listed above.
#[derive(Clone, Debug)]
struct Operators;

impl MakeOperators<f64> for Operators {
    fn make<'a>() -> Vec<Operator<'a, f64>> {
        let listed = |operator: &Operator<f64>| {
            FUNCTIONS.contains(&operator.repr()) || FUNCTIONS_OF_TWO.contains(&operator.repr())
        };
        let mut operators = FloatOpsFactory::make();
        // The rest is either not ours (`e`, `signum`) or defined below.
        operators.retain(listed);
        operators.extend([
            Operator::make_bin_unary("+", left_to_right(0, |a, b| a + b), |a| a),
            Operator::make_bin_unary("-", left_to_right(0, |a, b| a - b), |a| -a),
            Operator::make_bin("*", left_to_right(1, |a, b| a * b)),
            Operator::make_bin("/", left_to_right(1, |a, b| a / b)),
            Operator::make_bin("^", left_to_right(2, f64::powf)),
            Operator::make_unary("erf", libm::erf),
            Operator::make_unary("erfc", libm::erfc),
            Operator::make_unary("step", |x| if x < 0.0 { 0.0 } else { 1.0 }),
        ]);
        operators
    }
}

/// An operator that the library must not reorder. Its own put `-` before `+` and `/` before `*`,
/// so that `a*b/c` is a*(b/c), which rounds and overflows differently from what is written.
fn left_to_right(prio: i64, apply: fn(f64, f64) -> f64) -> BinOp<f64> {
    BinOp { apply, prio, is_commutative: false }
}

type Formula = FlatEx<f64, Operators, Literal>;

/// A parsed expression.
#[derive(Debug)]
pub(super) struct Expression {
    /// In a box, since the library keeps kilobytes of it in place.
    formula: Box<Formula>,
    /// Which of the [`VARIABLES`] it depends on, in their order.
    variables: Vec<usize>,
    /// The value, if it depends on none.
    constant: Option<f64>,
}

impl Expression {
    /// Parses `text`; `meaning` says what a name stands for, or why it stands for nothing.
    pub(super) fn parse(
        text: &str,
        meaning: &dyn Fn(&str) -> Result<Meaning, String>,
    ) -> Result<Self, String> {
        let rewritten = rewrite::rewrite(text, meaning)?;
        let formula = Box::new(Formula::parse(&rewritten).map_err(|error| error.to_string())?);
        let names = formula.var_names();
        let used = |&variable: &usize| names.iter().any(|name| name == VARIABLES[variable]);
        let mut expression = Self {
            variables: (0..VARIABLES.len()).filter(used).collect(),
            formula,
            constant: None,
        };
        if expression.variables.is_empty() {
            expression.constant = Some(expression.eval(DVec3::ZERO, 0.0));
        }
        Ok(expression)
    }

    /// The value at position `x` (m) and time `t` (s).
    pub(super) fn eval(&self, x: DVec3, t: f64) -> f64 {
        if let Some(value) = self.constant {
            return value;
        }
        let known = [t, x.x, x.y, x.z];
        let mut values = [0.0; VARIABLES.len()];
        for (value, &variable) in values.iter_mut().zip(&self.variables) {
            *value = known[variable];
        }
        // It fails only with fewer values than variables, which are all among the four.
        self.formula.eval_relaxed(&values).unwrap_or(f64::NAN)
    }

    /// The value, if it depends on neither position nor time.
    pub(super) fn constant(&self) -> Option<f64> {
        self.constant
    }

    /// Whether the value may differ from place to place.
    pub(super) fn depends_on_position(&self) -> bool {
        self.variables.iter().any(|&variable| variable != TIME)
    }

    /// Whether the value may change in time.
    pub(super) fn depends_on_time(&self) -> bool {
        self.variables.contains(&TIME)
    }
}
