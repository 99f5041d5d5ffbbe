//! Checks an expression and spells it as exmex reads it.
//!
//! exmex gives no places, has no numbers like `1e-3`, takes `-x^2` for `(-x)^2`, and cannot nest functions of two
//! arguments; unclosed braces and some characters make it panic. So a text is checked here, token by token with a
//! stack of open parentheses, and handed on with plain decimals, `(0-1)*` for a sign, and `((a)max(b))` for
//! `max(a, b)`.

use super::words::{FUNCTIONS, NAMES};
use super::{DEEPEST_EXPRESSION, ExpressionError, LONGEST_EXPRESSION};
use crate::diagnostic::{excerpt, nearest};
use std::fmt::Write as _;
use std::ops::Range;

const OPERAND: &str = "a number, `x`, `y`, `pi`, a function or `(`";

/// Spells an expression for exmex.
pub(super) fn spell(text: &str) -> Result<String, ExpressionError> {
    if text.len() > LONGEST_EXPRESSION {
        let message = format!("the expression has {} bytes", text.len());
        let expected = format!("at most {LONGEST_EXPRESSION}");
        return Err(fault(0..text.len(), message).expected(expected));
    }
    if text.trim().is_empty() {
        return Err(fault(0..text.len(), "the expression is empty".to_owned()).expected(OPERAND));
    }
    let mut speller = Speller {
        text,
        at: 0,
        out: String::with_capacity(2 * text.len()),
        open: Vec::new(),
        power: false,
        before: Before::Start,
    };
    while let Some(c) = text[speller.at..].chars().next() {
        speller.token(c)?;
    }
    speller.end()
}

fn fault(span: Range<usize>, message: String) -> ExpressionError {
    ExpressionError { span, message, expected: None, help: None }
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

/// What precedes the present token.
#[derive(Clone, Copy, PartialEq)]
enum Before {
    /// Nothing, an opening parenthesis or a comma.
    Start,
    /// An operator.
    Operator(char),
    /// A sign.
    Sign,
    /// A number, a name, a closing parenthesis.
    Operand,
}

/// An open parenthesis.
struct Open {
    at: usize,
    /// The function whose arguments it opens, and how many have begun.
    function: Option<(&'static str, usize)>,
    arguments: usize,
    /// Whether the term around it has a power already.
    power: bool,
}

struct Speller<'a> {
    text: &'a str,
    at: usize,
    out: String,
    open: Vec<Open>,
    /// Whether the present term ends with a power.
    power: bool,
    before: Before,
}

impl Speller<'_> {
    fn token(&mut self, c: char) -> Result<(), ExpressionError> {
        let start = self.at;
        let span = start..start + c.len_utf8();
        match c {
            ' ' | '\t' | '\n' | '\r' => {
                self.at = span.end;
                return Ok(());
            }
            '0'..='9' | '.' => return self.number(),
            'a'..='z' | 'A'..='Z' | '_' => return self.name(),
            '(' => {
                self.operand(&span)?;
                self.open(start, None)?;
                self.out.push('(');
            }
            ')' => self.close(span.clone())?,
            ',' => self.comma(span.clone())?,
            '+' | '-' if self.before != Before::Operand => self.sign(c, span.clone())?,
            '+' | '-' | '*' | '/' | '^' => self.operator(c, span.clone())?,
            _ => {
                let found = format!("the character {} is not allowed here", excerpt(&c.to_string()));
                return Err(fault(span, found).expected("numbers, names, `+ - * / ^ ( ) ,`"));
            }
        }
        self.at = span.end;
        Ok(())
    }

    /// Refuses an operand right behind another.
    fn operand(&self, span: &Range<usize>) -> Result<(), ExpressionError> {
        if self.before != Before::Operand {
            return Ok(());
        }
        let found = format!("an operator is missing before {}", excerpt(&self.text[span.clone()]));
        Err(fault(span.clone(), found).help("a product is written with `*`"))
    }

    fn number(&mut self) -> Result<(), ExpressionError> {
        let rest = &self.text[self.at..];
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
        // What cannot belong to a number is named with it: `1.2.3`, `2x`, `1_000`.
        let tail =
            rest[length..].bytes().take_while(|b| b.is_ascii_alphanumeric() || b"._".contains(b)).count();
        let span = self.at..self.at + length;
        let whole = self.at..span.end + tail;
        self.operand(&whole)?;
        let value = rest[..length].parse::<f64>().ok().filter(|v| v.is_finite());
        let Some(value) = value.filter(|_| tail == 0) else {
            let found = format!("{} is not a number", excerpt(&self.text[whole.clone()]));
            return Err(fault(whole, found).expected("a finite number, such as 0.5 or 1e-3"));
        };
        // Without an exponent, and exactly the same number.
        let _ = write!(self.out, "{value}");
        self.at = span.end;
        self.before = Before::Operand;
        Ok(())
    }

    fn name(&mut self) -> Result<(), ExpressionError> {
        let rest = &self.text[self.at..];
        let length = rest.bytes().take_while(|b| b.is_ascii_alphanumeric() || *b == b'_').count();
        let name = &rest[..length];
        let span = self.at..self.at + length;
        self.operand(&span)?;
        let gap = rest[length..].len() - rest[length..].trim_start().len();
        let called = rest[length + gap..].starts_with('(');
        if NAMES.contains(&name) {
            self.out += name;
            self.at = span.end;
            self.before = Before::Operand;
            return Ok(());
        }
        let Some(&function) = FUNCTIONS.iter().find(|(known, _)| *known == name) else {
            return Err(unknown(name, span, called));
        };
        if !called {
            let found = format!("`{name}` is a function without its arguments");
            let arguments = if function.1 == 1 { "…" } else { "…, …" };
            return Err(fault(span, found).expected(format!("`{name}({arguments})`")));
        }
        self.open(span.end + gap, Some(function))?;
        match function.1 {
            1 => {
                self.out += name;
                self.out.push('(');
            }
            _ => self.out += "((",
        }
        self.at = span.end + gap + 1;
        Ok(())
    }

    fn open(&mut self, at: usize, function: Option<(&'static str, usize)>) -> Result<(), ExpressionError> {
        if self.open.len() == DEEPEST_EXPRESSION {
            let found = "the parentheses are nested too deeply".to_owned();
            return Err(
                fault(at..at + 1, found).expected(format!("at most {DEEPEST_EXPRESSION} open at once"))
            );
        }
        self.open.push(Open { at, function, arguments: 1, power: self.power });
        self.power = false;
        self.before = Before::Start;
        Ok(())
    }

    /// Refuses a place where an operand is missing.
    fn complete(&self, span: Range<usize>, before: &str) -> Result<(), ExpressionError> {
        match self.before {
            Before::Operand => Ok(()),
            _ => Err(fault(span, format!("something is missing before {before}")).expected(OPERAND)),
        }
    }

    fn close(&mut self, span: Range<usize>) -> Result<(), ExpressionError> {
        let Some(open) = self.open.pop() else {
            return Err(fault(span, "`)` closes nothing".to_owned()).help("remove it, or open it with `(`"));
        };
        self.complete(span.clone(), "`)`")?;
        if let Some((name, arity)) = open.function
            && open.arguments < arity
        {
            let found = format!("`{name}` has {} argument", open.arguments);
            return Err(fault(span, found).expected(format!("{arity} arguments, `{name}(…, …)`")));
        }
        self.out += if open.function.is_some_and(|f| f.1 == 2) { "))" } else { ")" };
        self.power = open.power;
        self.before = Before::Operand;
        Ok(())
    }

    fn comma(&mut self, span: Range<usize>) -> Result<(), ExpressionError> {
        self.complete(span.clone(), "`,`")?;
        let Some(Open { function: Some((name, arity)), arguments, .. }) = self.open.last_mut() else {
            let found = "`,` is outside the arguments of a function".to_owned();
            return Err(fault(span, found).help("decimals are written with a point"));
        };
        if *arguments == *arity {
            let found =
                format!("`{name}` has more than {arity} argument{}", if *arity == 1 { "" } else { "s" });
            return Err(fault(span, found).expected(format!("{arity}")));
        }
        *arguments += 1;
        let _ = write!(self.out, "){name}(");
        self.power = false;
        self.before = Before::Start;
        Ok(())
    }

    fn sign(&mut self, c: char, span: Range<usize>) -> Result<(), ExpressionError> {
        match self.before {
            Before::Sign => {
                let found = "two consecutive signs".to_owned();
                return Err(fault(span, found).help("put the second sign and its operand into parentheses"));
            }
            _ if c == '+' => {}
            // The sign is that of the exponent alone, which is one operand.
            Before::Operator('^') => self.out.push('-'),
            // a / -b is a * (-1) / b.
            Before::Operator('/') => {
                self.out.pop();
                self.out += "*(0-1)/";
            }
            _ => self.out += "(0-1)*",
        }
        self.before = Before::Sign;
        Ok(())
    }

    fn operator(&mut self, c: char, span: Range<usize>) -> Result<(), ExpressionError> {
        if self.before == Before::Operator('*') && c == '*' {
            let twice = span.start - 1..span.end;
            return Err(
                fault(twice, "`**` is not an operator".to_owned()).help("a power is written with `^`")
            );
        }
        self.complete(span.clone(), &format!("`{c}`"))?;
        if c == '^' && self.power {
            let found = "a power of a power without parentheses can be read in two ways".to_owned();
            return Err(fault(span, found).expected("`(a^b)^c` or `a^(b^c)`"));
        }
        self.power = c == '^';
        self.out.push(c);
        self.before = Before::Operator(c);
        Ok(())
    }

    fn end(self) -> Result<String, ExpressionError> {
        let end = self.text.trim_end().len();
        self.complete(end..end, "the end")?;
        match self.open.last() {
            Some(open) => {
                let found = "`(` is not closed".to_owned();
                Err(fault(open.at..open.at + 1, found).expected("a `)` for it"))
            }
            None => Ok(self.out),
        }
    }
}

/// Makes the error of an unknown name.
fn unknown(name: &str, span: Range<usize>, called: bool) -> ExpressionError {
    let functions = FUNCTIONS.iter().map(|f| f.0);
    let known: Vec<&str> =
        if called { functions.collect() } else { NAMES.into_iter().chain(functions).collect() };
    // Any two names of one letter are near each other.
    let near =
        nearest(name, known.iter().copied()).filter(|near| name.len() > 1 || near.eq_ignore_ascii_case(name));
    let help = match near {
        _ if name == "e" => "write `exp(1)` for Euler's number".to_owned(),
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("the names here are {}", known.join(", ")),
    };
    let what = if called { "function" } else { "name" };
    fault(span, format!("unknown {what} {}", excerpt(name))).help(help)
}
