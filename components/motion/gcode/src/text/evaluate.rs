//! Values of expressions.

use crate::{
    error::Problem,
    text::expression::{Expr, Function, Left, Operator},
};

/// Values nearer than this are equal to `eq`, `ne` and to integers.
pub const TOLERANCE: f64 = 0.0001;

/// The parameters that an expression may read.
pub trait Values {
    /// Returns the numbered parameter.
    fn numbered(&self, index: i32) -> Result<f64, Problem>;
    /// Returns the named parameter.
    fn named(&self, name: &str) -> Result<f64, Problem>;
    /// Tells whether the named parameter exists.
    fn exists(&self, name: &str) -> bool;
}

/// A problem and its place, as bytes from the end of the cleaned line.
pub type Failure = (Left, Problem);

/// Returns the value of `expr`; a failure without a place of its own is at `at`.
pub fn evaluate(expr: &Expr, at: Left, values: &dyn Values) -> Result<f64, Failure> {
    let result = match expr {
        Expr::Number(n) => return Ok(*n),
        Expr::Numbered(at, index) => {
            let index = integer(evaluate(index, *at, values)?).map_err(|p| (*at, p))?;
            return values.numbered(index).map_err(|p| (*at, p));
        }
        Expr::Named(at, name) => return values.named(name).map_err(|p| (*at, p)),
        Expr::ExistsNumbered(at, index) => {
            let index = integer(evaluate(index, *at, values)?).map_err(|p| (*at, p))?;
            let exists = index > 0 && values.numbered(index).is_ok();
            return Ok(if exists { 1.0 } else { 0.0 });
        }
        Expr::Exists(name) => return Ok(if values.exists(name) { 1.0 } else { 0.0 }),
        Expr::Negative(inner) => return Ok(-evaluate(inner, at, values)?),
        Expr::Call(at, function, inner) => {
            let x = evaluate(inner, *at, values)?;
            call(*function, x).map_err(|p| (*at, p))?
        }
        Expr::Atan(y, x) => {
            let (y, x) = (evaluate(y, at, values)?, evaluate(x, at, values)?);
            libm::atan2(y, x).to_degrees()
        }
        Expr::Binary(at, operator, a, b) => {
            let (a, b) = (evaluate(a, *at, values)?, evaluate(b, *at, values)?);
            binary(*operator, a, b).map_err(|p| (*at, p))?
        }
    };
    if result.is_nan() {
        return Err((at, Problem::NotANumber));
    }
    if result.is_infinite() {
        return Err((at, Problem::Infinite));
    }
    Ok(result)
}

/// Returns the integer that `value` is, within the tolerance.
pub fn integer(value: f64) -> Result<i32, Problem> {
    let nearest = libm::round(value);
    if libm::fabs(value - nearest) > TOLERANCE || nearest.is_nan() {
        return Err(Problem::NotAnInteger);
    }
    if !(-2_147_483_648.0..=2_147_483_647.0).contains(&nearest) {
        return Err(Problem::NumberTooLarge);
    }
    #[expect(clippy::cast_possible_truncation, reason = "the range was checked")]
    Ok(nearest as i32)
}

fn call(function: Function, x: f64) -> Result<f64, Problem> {
    let unit = || (-1.0..=1.0).contains(&x);
    Ok(match function {
        Function::Abs => libm::fabs(x),
        Function::Acos if unit() => libm::acos(x).to_degrees(),
        Function::Asin if unit() => libm::asin(x).to_degrees(),
        Function::Acos => return Err(Problem::AcosRange),
        Function::Asin => return Err(Problem::AsinRange),
        Function::Cos => libm::cos(x.to_radians()),
        Function::Exp => libm::exp(x),
        Function::Fix => libm::floor(x),
        Function::Fup => libm::ceil(x),
        Function::Ln if x > 0.0 => libm::log(x),
        Function::Ln => return Err(Problem::LnRange),
        Function::Round => libm::round(x),
        Function::Sin => libm::sin(x.to_radians()),
        Function::Sqrt if x >= 0.0 => libm::sqrt(x),
        Function::Sqrt => return Err(Problem::SqrtRange),
        Function::Tan => libm::tan(x.to_radians()),
    })
}

fn binary(operator: Operator, a: f64, b: f64) -> Result<f64, Problem> {
    let truth = |t: bool| if t { 1.0 } else { 0.0 };
    let near = || libm::fabs(a - b) < TOLERANCE;
    Ok(match operator {
        Operator::Power => {
            if a < 0.0 && libm::floor(b) != b {
                return Err(Problem::PowerRange);
            }
            libm::pow(a, b)
        }
        Operator::Times => a * b,
        Operator::Divide | Operator::Modulo if b == 0.0 => return Err(Problem::DivideByZero),
        Operator::Divide => a / b,
        Operator::Modulo => {
            let rest = libm::fmod(a, b);
            if rest < 0.0 { rest + libm::fabs(b) } else { rest }
        }
        Operator::Plus => a + b,
        Operator::Minus => a - b,
        Operator::Equal => truth(near()),
        Operator::NotEqual => truth(!near()),
        Operator::Greater => truth(a > b),
        Operator::GreaterOrEqual => truth(a >= b),
        Operator::Less => truth(a < b),
        Operator::LessOrEqual => truth(a <= b),
        Operator::And => truth(a != 0.0 && b != 0.0),
        Operator::Or => truth(a != 0.0 || b != 0.0),
        Operator::Xor => truth((a != 0.0) != (b != 0.0)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::expression::bracketed;

    struct Few;
    impl Values for Few {
        fn numbered(&self, index: i32) -> Result<f64, Problem> {
            Ok(f64::from(index) + 0.5)
        }
        fn named(&self, _: &str) -> Result<f64, Problem> {
            Ok(7.0)
        }
        fn exists(&self, name: &str) -> bool {
            name == "a"
        }
    }

    fn value(text: &str) -> Result<f64, Problem> {
        match bracketed(text.as_bytes()) {
            Ok((rest, e)) => {
                assert!(rest.is_empty(), "{text}");
                evaluate(&e, 0, &Few).map_err(|f| f.1)
            }
            Err(nom::Err::Failure(f) | nom::Err::Error(f)) => Err(f.problem),
            Err(nom::Err::Incomplete(_)) => panic!(),
        }
    }

    #[test]
    fn operators_bind_as_in_the_reference() {
        let cases = [
            ("[2**3**2]", 64.0),
            ("[-2**2]", 4.0),
            ("[1+2*3-4/2]", 5.0),
            ("[-7mod3]", 2.0),
            ("[1or0and0]", 0.0),
            ("[2gt1and1gt0]", 1.0),
            ("[1eq1.00005]", 1.0),
            ("[#3+#<x>]", 10.5),
            ("[exists[#<a>]+exists[#<b>]]", 1.0),
            ("[atan[1]/[-1]]", 135.0),
            ("[--[2]]", 2.0),
            ("[round[-2.5]+fix[-2.5]+fup[2.1]]", -3.0),
        ];
        for (text, expected) in cases {
            assert_eq!(value(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn impossible_values_are_problems() {
        let cases = [
            ("[1/0]", Problem::DivideByZero),
            ("[ln[0]]", Problem::LnRange),
            ("[sqrt[-1]]", Problem::SqrtRange),
            ("[asin[2]]", Problem::AsinRange),
            ("[[-1]**0.5]", Problem::PowerRange),
            ("[10**400]", Problem::Infinite),
            ("[#1.5]", Problem::NotAnInteger),
            ("[1+", Problem::NoNumber),
            ("[1", Problem::UnclosedExpression),
            ("[1?2]", Problem::UnknownOperator),
        ];
        for (text, expected) in cases {
            assert_eq!(value(text), Err(expected), "{text}");
        }
        let deep = "[".repeat(5000);
        assert!(matches!(value(&deep), Err(Problem::NestedTooDeep { .. })));
        let deep = format!("[{}1]", "#".repeat(5000));
        assert!(matches!(value(&deep), Err(Problem::NestedTooDeep { .. })));
    }
}
