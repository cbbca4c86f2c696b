//! A calculator: what stands in the formulas of an explanation, in exact fractions.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Pow, Signed, Zero};

/// One number, or three.
type Value = Vec<BigRational>;

/// What the formulas of an explanation's text say of numbers: how many expressions were calculated, and
/// each that doesn't give the result that is printed, rounded to `digits` digits.
pub fn checked(text: &str, digits: usize) -> (usize, Vec<String>) {
    let (mut n_checked, mut wrong) = (0, Vec::new());
    for line in logical_lines(text) {
        let parts = parts_of(&line);
        for (i, part) in parts.iter().enumerate() {
            let pieces = part.replace(" ≈ ", " = ");
            let pieces: Vec<&str> = pieces.split(" = ").collect();
            let expressions: Vec<(&str, Value)> =
                pieces.iter().filter_map(|piece| Some((*piece, value(piece)?))).collect();
            // The results of a formula with two of them follow as t₁ and t₂.
            let told: Option<Vec<String>> = parts[i + 1..]
                .iter()
                .take_while(|part| part.starts_with("t₁") || part.starts_with("t₂"))
                .map(|part| Some(part.split_once(['=', '≈'])?.1.trim().to_owned()))
                .collect();
            let told = told.unwrap_or_default();
            let results: Vec<String> = match pieces.last() {
                Some(last) if part.contains('±') && !told.is_empty() => {
                    assert!(last.contains('±'), "{line}");
                    told
                }
                Some(last) => {
                    last.trim_matches(['(', ')']).split(", ").map(str::to_owned).collect()
                }
                None => continue,
            };
            for (piece, found) in &expressions {
                if results.iter().any(|result| number(result).is_none())
                    || results.len() == 1 && *piece == results[0]
                {
                    continue;
                }
                n_checked += 1;
                // D = 0 has one root, twice.
                let found = match (found.len(), results.len()) {
                    (2, 1) if found[0] == found[1] => &found[..1],
                    _ => &found[..],
                };
                let is_right = found.len() == results.len()
                    && found.iter().zip(&results).all(|(x, printed)| rounds_to(x, printed, digits));
                if !is_right {
                    wrong.push(format!("{piece} is not {results:?} in: {line}"));
                }
            }
        }
    }
    (n_checked, wrong)
}

/// The formulas, each on a line.
fn logical_lines(text: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines() {
        let indent = line.len() - line.trim_start().len();
        let goes_on = line.trim_start().starts_with(['=', '≈']);
        match lines.last_mut() {
            Some(last) if indent == 6 && goes_on || indent == 8 => {
                last.push(' ');
                *last += line.trim();
            }
            // What had no room beside its formula.
            Some(last) if indent == 2 && is_root(line.trim()) => {
                *last += ", ";
                *last += line.trim();
            }
            _ if indent == 2 && !line.contains('→') => lines.push(line.trim().to_owned()),
            _ => {}
        }
    }
    lines
}

/// `t₁ ≈ 36`
fn is_root(line: &str) -> bool {
    let rest = line.strip_prefix("t₁ ").or_else(|| line.strip_prefix("t₂ "));
    rest.is_some_and(|rest| rest.starts_with(['=', '≈']))
}

/// What stands between commas that are in no parentheses.
fn parts_of(line: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut depth = 0;
    for c in line.chars() {
        depth += i32::from(c == '(') - i32::from(c == ')');
        match c {
            ',' if depth == 0 => parts.push(String::new()),
            _ => parts.last_mut().unwrap().push(c),
        }
    }
    parts.iter().map(|part| part.trim().to_owned()).collect()
}

/// Whether a number is at most half a unit of the last of so many digits away from a printed one. The
/// digits of a 0 say nothing.
fn rounds_to(x: &BigRational, printed: &str, digits: usize) -> bool {
    let (value, leading) = number(printed).unwrap();
    let half_unit = ten(leading - digits as i64 + 1) / BigInt::from(2);
    value.is_zero() || (x - value).abs() <= half_unit
}

fn ten(exponent: i64) -> BigRational {
    let power = BigRational::from(BigInt::from(10).pow(exponent.unsigned_abs()));
    if exponent < 0 { power.recip() } else { power }
}

/// A number as it is printed, and the exponent of its first digit.
fn number(text: &str) -> Option<(BigRational, i64)> {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let exponent: i64 = exponent.parse().ok()?;
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let is_digits = |text: &str| text.chars().all(|c| c.is_ascii_digit());
    let digits = whole.strip_prefix('-').unwrap_or(whole);
    if digits.is_empty() || !is_digits(digits) || !is_digits(fraction) {
        return None;
    }
    let all: BigInt = format!("{whole}{fraction}").parse().ok()?;
    let scale = exponent - fraction.len() as i64;
    let n_digits = all.abs().to_string().len() as i64;
    Some((BigRational::from(all) * ten(scale), scale + n_digits - 1))
}

/// The square root to some 200 digits.
fn sqrt(x: &BigRational) -> Option<BigRational> {
    if x.is_negative() {
        return None;
    }
    let scale = ten(400 + x.denom().to_string().len() as i64).to_integer();
    let root = (x.numer() * x.denom() * &scale * &scale).sqrt();
    Some(BigRational::new(root, x.denom() * scale))
}

/// The value of an expression, with `•` for the scalar product; `None` for one with letters in it. A `±`
/// gives two.
pub fn value(text: &str) -> Option<Value> {
    if text.contains('±') {
        let [low, high] = ["−", "+"].map(|sign| value(&text.replace('±', sign)));
        return Some([low?, high?].concat());
    }
    let chars: Vec<char> = text.chars().filter(|c| *c != ' ').collect();
    let mut rest = &chars[..];
    let found = sum(&mut rest)?;
    rest.is_empty().then_some(found)
}

fn sum(rest: &mut &[char]) -> Option<Value> {
    let mut all = product(rest)?;
    while let Some(sign @ ('+' | '−')) = rest.first() {
        *rest = &rest[1..];
        let next = product(rest)?;
        if next.len() != all.len() {
            return None;
        }
        let sign = BigRational::from(BigInt::from(if *sign == '+' { 1 } else { -1 }));
        all = all.iter().zip(next).map(|(x, y)| x + y * &sign).collect();
    }
    Some(all)
}

fn product(rest: &mut &[char]) -> Option<Value> {
    let mut all = power(rest)?;
    while let Some(sign @ ('·' | '•' | '/')) = rest.first() {
        *rest = &rest[1..];
        let next = power(rest)?;
        all = match (sign, &all[..], &next[..]) {
            ('•', [_, _, _], [_, _, _]) => vec![all.iter().zip(&next).map(|(x, y)| x * y).sum()],
            ('·', many, [one]) | ('·', [one], many) => many.iter().map(|x| x * one).collect(),
            ('/', many, [one]) if !one.is_zero() => many.iter().map(|x| x / one).collect(),
            _ => return None,
        };
    }
    Some(all)
}

fn power(rest: &mut &[char]) -> Option<Value> {
    let base = single(rest)?;
    if rest.first() == Some(&'²') {
        *rest = &rest[1..];
        let [x] = &base[..] else { return None };
        return Some(vec![x.pow(2)]);
    }
    Some(base)
}

fn single(rest: &mut &[char]) -> Option<Value> {
    match rest.first()? {
        '−' => {
            *rest = &rest[1..];
            Some(power(rest)?.iter().map(|x| -x).collect())
        }
        '√' => {
            *rest = &rest[1..];
            let [x] = &single(rest)?[..] else { return None };
            Some(vec![sqrt(x)?])
        }
        '(' => {
            *rest = &rest[1..];
            let mut all = sum(rest)?;
            while rest.first() == Some(&',') {
                *rest = &rest[1..];
                all.extend(sum(rest)?);
            }
            *rest = rest.strip_prefix(&[')'])?;
            Some(all)
        }
        _ => {
            let is_part = |i: usize, c: char| {
                c.is_ascii_digit()
                    || c == '.'
                    || c == 'e'
                    || c == '-' && (i == 0 || rest[i - 1] == 'e')
            };
            let end = (0..rest.len()).find(|&i| !is_part(i, rest[i])).unwrap_or(rest.len());
            let text: String = rest[..end].iter().collect();
            *rest = &rest[end..];
            Some(vec![number(&text)?.0])
        }
    }
}
