//! Reads the text of an expression into a tree, by recursive descent, with the place of every fault.
//!
//! ```text
//! sum     = product { ("+" | "-") product }
//! product = factor { ("*" | "/") factor }
//! factor  = [ "+" | "-" ] power
//! power   = operand [ "^" [ "+" | "-" ] operand ]
//! operand = number | coordinate | "pi" | "(" sum ")" | function "(" sum [ "," sum ] ")"
//! ```

use super::words::{COORDINATES, FUNCTIONS, Function, PI, function, quoted};
use super::{DEEPEST_EXPRESSION, ExpressionError, LONGEST_EXPRESSION};
use crate::diagnostic::{excerpt, nearest};
use std::ops::{Index, Range};

/// An expression to be evaluated.
#[derive(Debug)]
pub(super) enum Node {
    Number(f64),
    /// 0 for x, 1 for y, 2 for z.
    Coordinate(usize),
    One(fn(f64) -> f64, Box<Self>),
    Two(fn(f64, f64) -> f64, Box<[Self; 2]>),
}

impl Node {
    /// Evaluates the expression at a point.
    pub(super) fn at(&self, point: &impl Index<usize, Output = f64>) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Coordinate(axis) => point[*axis],
            Self::One(function, argument) => function(argument.at(point)),
            Self::Two(function, arguments) => function(arguments[0].at(point), arguments[1].at(point)),
        }
    }

    /// Says whether a coordinate is in the expression.
    pub(super) fn uses_coordinates(&self) -> bool {
        match self {
            Self::Number(_) => false,
            Self::Coordinate(_) => true,
            Self::One(_, argument) => argument.uses_coordinates(),
            Self::Two(_, arguments) => arguments.iter().any(Self::uses_coordinates),
        }
    }
}

/// Reads an expression.
///
/// * `coordinates`: their names.
pub(super) fn parse(text: &str, coordinates: &'static [&'static str]) -> Result<Node, ExpressionError> {
    if text.len() > LONGEST_EXPRESSION {
        let message = format!("the expression has {} bytes", text.len());
        let expected = format!("at most {LONGEST_EXPRESSION}");
        return Err(fault(0..text.len(), message).expected(expected));
    }
    let mut parser = Parser { text, coordinates, at: 0, open: 0 };
    if text.trim().is_empty() {
        return Err(fault(0..text.len(), "the expression is empty").expected(parser.operands()));
    }
    let node = parser.sum()?;
    match parser.next() {
        None => Ok(node),
        Some(_) => Err(parser.misplaced()),
    }
}

fn fault(span: Range<usize>, message: impl Into<String>) -> ExpressionError {
    ExpressionError { span, message: message.into(), expected: None, help: None }
}

impl ExpressionError {
    fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }

    fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

struct Parser<'a> {
    text: &'a str,
    coordinates: &'static [&'static str],
    /// Byte to be read next.
    at: usize,
    /// Number of open parentheses.
    open: usize,
}

impl<'a> Parser<'a> {
    /// Returns the next character that is not a blank, without reading it.
    fn next(&mut self) -> Option<char> {
        let rest = self.rest();
        self.at += rest.len() - rest.trim_start_matches([' ', '\t', '\n', '\r']).len();
        self.rest().chars().next()
    }

    /// Says what may be an operand.
    fn operands(&self) -> String {
        format!("a number, {}`{PI}`, a function or `(`", quoted(self.coordinates))
    }

    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    /// The bytes of the next character.
    fn here(&self) -> Range<usize> {
        self.at..self.at + self.rest().chars().next().map_or(0, char::len_utf8)
    }

    /// Reads the next character if it is one of `wanted`, all ASCII.
    fn take(&mut self, wanted: &[char]) -> Option<char> {
        let found = self.next().filter(|c| wanted.contains(c))?;
        self.at += 1;
        Some(found)
    }

    fn sum(&mut self) -> Result<Node, ExpressionError> {
        let mut sum = self.product()?;
        while let Some(operator) = self.take(&['+', '-']) {
            let function: fn(f64, f64) -> f64 = if operator == '+' { |a, b| a + b } else { |a, b| a - b };
            sum = Node::Two(function, Box::new([sum, self.product()?]));
        }
        Ok(sum)
    }

    fn product(&mut self) -> Result<Node, ExpressionError> {
        let mut product = self.factor()?;
        while let Some(operator) = self.take(&['*', '/']) {
            if operator == '*' && self.rest().starts_with('*') {
                let twice = self.at - 1..self.at + 1;
                return Err(fault(twice, "`**` is not an operator").help("a power is written with `^`"));
            }
            let function: fn(f64, f64) -> f64 = if operator == '*' { |a, b| a * b } else { |a, b| a / b };
            product = Node::Two(function, Box::new([product, self.factor()?]));
        }
        Ok(product)
    }

    fn factor(&mut self) -> Result<Node, ExpressionError> {
        self.signed(Self::power)
    }

    fn power(&mut self) -> Result<Node, ExpressionError> {
        let base = self.operand()?;
        if self.take(&['^']).is_none() {
            return Ok(base);
        }
        let exponent = self.signed(Self::operand)?;
        if self.next() == Some('^') {
            let found = "a power of a power without parentheses can be read in two ways";
            return Err(fault(self.here(), found).expected("`(a^b)^c` or `a^(b^c)`"));
        }
        Ok(Node::Two(f64::powf, Box::new([base, exponent])))
    }

    /// Reads what may have a sign before it.
    fn signed(
        &mut self,
        unsigned: fn(&mut Self) -> Result<Node, ExpressionError>,
    ) -> Result<Node, ExpressionError> {
        let sign = self.take(&['+', '-']);
        if sign.is_some() && matches!(self.next(), Some('+' | '-')) {
            let help = "put the second sign and its operand into parentheses";
            return Err(fault(self.here(), "two consecutive signs").help(help));
        }
        let node = unsigned(self)?;
        Ok(if sign == Some('-') { Node::One(|a| -a, Box::new(node)) } else { node })
    }

    fn operand(&mut self) -> Result<Node, ExpressionError> {
        match self.next() {
            Some('0'..='9' | '.') => self.number(),
            Some('a'..='z' | 'A'..='Z' | '_') => self.name(),
            Some('(') => {
                let start = self.enter()?;
                let node = self.sum()?;
                self.leave(start)?;
                Ok(node)
            }
            Some(')') if self.open == 0 => Err(self.misplaced()),
            Some(c @ ('+' | '-' | '*' | '/' | '^' | ')' | ',')) => {
                Err(fault(self.here(), format!("something is missing before `{c}`"))
                    .expected(self.operands()))
            }
            Some(_) => Err(self.misplaced()),
            None => {
                let end = self.text.trim_end().len();
                Err(fault(end..end, "something is missing before the end").expected(self.operands()))
            }
        }
    }

    /// Measures the number at the present place: its bytes, and those behind it that belong to no number, as in
    /// `1.2.3`, `2x`, `1_000`.
    fn measure_number(&self) -> (usize, usize) {
        let rest = self.rest();
        let digits = |from: usize| rest[from..].bytes().take_while(u8::is_ascii_digit).count();
        let mut length = digits(0);
        if rest[length..].starts_with('.') {
            length += 1 + digits(length + 1);
        }
        if rest[length..].starts_with(['e', 'E']) {
            let sign = usize::from(rest[length + 1..].starts_with(['+', '-']));
            let exponent = digits(length + 1 + sign);
            if exponent > 0 {
                length += 1 + sign + exponent;
            }
        }
        let tail =
            rest[length..].bytes().take_while(|b| b.is_ascii_alphanumeric() || b"._".contains(b)).count();
        (length, tail)
    }

    fn number(&mut self) -> Result<Node, ExpressionError> {
        let (length, tail) = self.measure_number();
        let value = self.rest()[..length].parse().ok().filter(|v: &f64| v.is_finite() && tail == 0);
        let Some(value) = value else {
            let whole = self.at..self.at + length + tail;
            let found = format!("{} is not a number", excerpt(&self.text[whole.clone()]));
            return Err(fault(whole, found).expected("a finite number, such as 0.5 or 1e-3"));
        };
        self.at += length;
        Ok(Node::Number(value))
    }

    fn measure_name(&self) -> usize {
        self.rest().bytes().take_while(|b| b.is_ascii_alphanumeric() || *b == b'_').count()
    }

    fn name(&mut self) -> Result<Node, ExpressionError> {
        let span = self.at..self.at + self.measure_name();
        let name = &self.text[span.clone()];
        self.at = span.end;
        if let Some(axis) = self.coordinates.iter().position(|axis| *axis == name) {
            return Ok(Node::Coordinate(axis));
        }
        if name == PI {
            return Ok(Node::Number(std::f64::consts::PI));
        }
        let called = self.next() == Some('(');
        let Some(function) = function(name) else { return Err(self.unknown(name, span, called)) };
        if !called {
            let found = format!("`{name}` is a function without its arguments");
            let arguments = if function.arity() == 1 { "…" } else { "…, …" };
            return Err(fault(span, found).expected(format!("`{name}({arguments})`")));
        }
        self.call(name, function)
    }

    fn call(&mut self, name: &str, function: Function) -> Result<Node, ExpressionError> {
        let start = self.enter()?;
        let first = self.sum()?;
        let node = match function {
            Function::One(function) => Node::One(function, Box::new(first)),
            Function::Two(function) => {
                if self.next() == Some(')') {
                    let found = format!("`{name}` has 1 argument");
                    return Err(fault(self.here(), found).expected(format!("2 arguments, `{name}(…, …)`")));
                }
                if self.take(&[',']).is_none() {
                    return Err(self.unclosed(start));
                }
                Node::Two(function, Box::new([first, self.sum()?]))
            }
        };
        if self.next() == Some(',') {
            let arity = function.arity();
            let found =
                format!("`{name}` has more than {arity} argument{}", if arity == 1 { "" } else { "s" });
            return Err(fault(self.here(), found).expected(format!("{arity}")));
        }
        self.leave(start)?;
        Ok(node)
    }

    /// Reads an opening parenthesis and returns its place.
    fn enter(&mut self) -> Result<usize, ExpressionError> {
        if self.open == DEEPEST_EXPRESSION {
            let found = "the parentheses are nested too deeply";
            let expected = format!("at most {DEEPEST_EXPRESSION} open at once");
            return Err(fault(self.here(), found).expected(expected));
        }
        self.open += 1;
        self.at += 1;
        Ok(self.at - 1)
    }

    /// Reads the closing parenthesis of the one at `start`.
    fn leave(&mut self, start: usize) -> Result<(), ExpressionError> {
        if self.take(&[')']).is_none() {
            return Err(self.unclosed(start));
        }
        self.open -= 1;
        Ok(())
    }

    /// Makes the error of a parenthesis that is neither closed nor followed by what continues the expression.
    fn unclosed(&mut self, start: usize) -> ExpressionError {
        match self.next() {
            Some(_) => self.misplaced(),
            None => fault(start..start + 1, "`(` is not closed").expected("a `)` for it"),
        }
    }

    /// Makes the error of a character that cannot follow what was read.
    fn misplaced(&self) -> ExpressionError {
        let here = self.here();
        let width = match self.rest().chars().next() {
            Some(')') => return fault(here, "`)` closes nothing").help("remove it, or open it with `(`"),
            Some(',') => {
                let found = "`,` is outside the arguments of a function";
                return fault(here, found).help("decimals are written with a point");
            }
            Some('(') => 1,
            Some('0'..='9' | '.') => {
                let (number, tail) = self.measure_number();
                number + tail
            }
            Some('a'..='z' | 'A'..='Z' | '_') => self.measure_name(),
            _ => {
                let found =
                    format!("the character {} is not allowed here", excerpt(&self.text[here.clone()]));
                return fault(here, found).expected("numbers, names, `+ - * / ^ ( ) ,`");
            }
        };
        let span = here.start..here.start + width;
        let found = format!("an operator is missing before {}", excerpt(&self.text[span.clone()]));
        fault(span, found).help("a product is written with `*`")
    }

    /// Makes the error of an unknown name.
    fn unknown(&self, name: &str, span: Range<usize>, called: bool) -> ExpressionError {
        let functions = FUNCTIONS.iter().map(|f| f.0);
        let numbers = self.coordinates.iter().copied().chain([PI]);
        let known: Vec<&str> = if called { functions.collect() } else { numbers.chain(functions).collect() };
        // Any two names of one letter are near each other.
        let near = nearest(name, known.iter().copied())
            .filter(|near| name.len() > 1 || near.eq_ignore_ascii_case(name));
        let help = match near {
            _ if name == "e" => "write `exp(1)` for Euler's number".to_owned(),
            Some(near) => format!("did you mean `{near}`?"),
            None if COORDINATES.contains(&name) => {
                format!("only cases of solids have the coordinate `{name}`")
            }
            None => format!("the names here are {}", known.join(", ")),
        };
        let what = if called { "function" } else { "name" };
        fault(span, format!("unknown {what} {}", excerpt(name))).help(help)
    }
}
