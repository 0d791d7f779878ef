//! Decimal numbers in text: to the nearest `f64` and `f32`, and back to the shortest text.
//!
//! Motion files are numbers, so this loop is where reading spends its time. Up to 19 digits are gathered in an
//! integer; where that is below 2^53 and scaled by at most 10^22, both are exact `f64`s and one division rounds
//! correctly (Clinger's fast path). Everything else goes to `fast-float2`, after its form has been checked here.

use super::finding::NumberFlaw;
use std::io::Write;

/// Powers of ten that an `f64` holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// More digits than this may overflow the integer they are gathered in.
const MAX_DIGITS: usize = 19;

/// The number at `start`: its value and where it ends. `None` where no number begins.
///
/// Accepts a sign, digits with at most one point (before, between or after them) and an exponent. The value is
/// the nearest `f64`; where that is infinite, there is no number. What follows it is the caller's to check.
#[inline(always)]
pub(crate) fn scan(bytes: &[u8], start: usize) -> Option<(f64, usize)> {
    let first = *bytes.get(start)?;
    let negative = first == b'-';
    let whole_from = start + usize::from(negative | (first == b'+'));
    let mut mantissa = 0_u64;
    let mut at = digits(bytes, whole_from, &mut mantissa);
    let mut n_digits = at - whole_from;
    let mut n_decimals = 0;
    if bytes.get(at) == Some(&b'.') {
        let from = at + 1;
        at = digits(bytes, from, &mut mantissa);
        n_decimals = at - from;
        n_digits += n_decimals;
    }
    if n_digits == 0 {
        return None;
    }
    let plain = !matches!(bytes.get(at), Some(b'e' | b'E'));
    if plain && n_digits <= MAX_DIGITS && mantissa <= 1 << 53 {
        let value = mantissa as f64 / POWERS[n_decimals];
        return Some((f64::from_bits(value.to_bits() | u64::from(negative) << 63), at));
    }
    scan_rare(bytes, start, at, mantissa, n_digits, n_decimals)
}

/// The nearest `f32` of the number at `bytes[start..end]`, whose nearest `f64` is `value`.
///
/// Rounding twice would miss it where `value` lies half-way between two `f32`s and the text does not.
#[inline(always)]
pub(crate) fn narrow(value: f64, bytes: &[u8], start: usize, end: usize) -> f32 {
    const BELOW_F32: u64 = (1 << 29) - 1;
    const HALF_WAY: u64 = 1 << 28;
    let bits = value.to_bits();
    if bits & BELOW_F32 == HALF_WAY || (value.abs() < f64::from(f32::MIN_POSITIVE) && value != 0.0) {
        return narrow_rare(value, bytes, start, end);
    }
    value as f32
}

/// A whole word as a finite `f64`; `None` if it is anything else.
pub fn parse(word: &[u8]) -> Option<f64> {
    let (value, end) = scan(word, 0)?;
    (end == word.len()).then_some(value)
}

/// A whole word as an `f64` within the range of `f32`; `None` if it is anything else.
pub(crate) fn parse_in_f32(word: &[u8]) -> Option<f64> {
    parse(word).filter(|value| value.abs() <= f64::from(f32::MAX))
}

/// What is wrong with a word that [`parse_in_f32`] refuses.
pub(crate) fn flaw(word: &[u8]) -> NumberFlaw {
    let bare = word.strip_prefix(b"-").or_else(|| word.strip_prefix(b"+")).unwrap_or(word);
    let starts = |name: &[u8]| bare.get(..name.len()).is_some_and(|head| head.eq_ignore_ascii_case(name));
    // 1.#QNAN and 1.#INF: the C library of Windows.
    if starts(b"nan") || starts(b"inf") || starts(b"1.#") {
        return NumberFlaw::NotFinite;
    }
    match scan(word, 0) {
        Some((_, end)) if end == word.len() => NumberFlaw::TooLarge,
        Some((_, end)) if word[end] == b',' => NumberFlaw::DecimalComma,
        None if fast_float2::parse::<f64, _>(bare).is_ok() => NumberFlaw::TooLarge,
        _ => NumberFlaw::Malformed,
    }
}

/// Appends the shortest decimal that reads back as the same `f32`, never with an exponent.
pub fn write_f32(out: &mut Vec<u8>, value: f32) {
    write!(out, "{value}").expect("writing to a Vec does not fail");
}

/// Appends the shortest decimal that reads back as the same `f64`, never with an exponent.
pub fn write_f64(out: &mut Vec<u8>, value: f64) {
    write!(out, "{value}").expect("writing to a Vec does not fail");
}

#[inline(always)]
fn digits(bytes: &[u8], mut at: usize, mantissa: &mut u64) -> usize {
    while let Some(&byte) = bytes.get(at) {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        // Wraps only beyond MAX_DIGITS, where it isn't used.
        *mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    at
}

/// Exponents, and more digits than the fast path holds. `at` is the end of the digits.
#[cold]
fn scan_rare(
    bytes: &[u8],
    start: usize,
    at: usize,
    mantissa: u64,
    n_digits: usize,
    n_decimals: usize,
) -> Option<(f64, usize)> {
    let negative = bytes[start] == b'-';
    let mut end = at;
    let mut exponent = 0_i64;
    if matches!(bytes.get(at), Some(b'e' | b'E')) {
        let sign = bytes.get(at + 1).copied();
        let from = at + 1 + usize::from(matches!(sign, Some(b'-' | b'+')));
        let mut size = 0_u64;
        let exponent_end = digits(bytes, from, &mut size);
        if exponent_end == from {
            // "1e" and "1e+" are numbers followed by something else.
            return fallback(&bytes[start..at]).map(|value| (value, at));
        }
        end = exponent_end;
        // An absurd exponent (wrapped or not) takes the fallback.
        exponent = if exponent_end - from > 4 { i64::MAX / 2 } else { size as i64 };
        if sign == Some(b'-') {
            exponent = -exponent;
        }
    }
    let scale = exponent - n_decimals as i64;
    if n_digits <= MAX_DIGITS && mantissa <= 1 << 53 && (-22..=22).contains(&scale) {
        let power = POWERS[scale.unsigned_abs() as usize];
        let value = if scale < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
        return Some((if negative { -value } else { value }, end));
    }
    fallback(&bytes[start..end]).map(|value| (value, end))
}

fn fallback(word: &[u8]) -> Option<f64> {
    fast_float2::parse(word.strip_prefix(b"+").unwrap_or(word)).ok().filter(|value: &f64| value.is_finite())
}

#[cold]
fn narrow_rare(value: f64, bytes: &[u8], start: usize, end: usize) -> f32 {
    let word = &bytes[start..end];
    fast_float2::parse(word.strip_prefix(b"+").unwrap_or(word)).unwrap_or(value as f32)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use proptest::prelude::*;

    fn f32_of(word: &str) -> f32 {
        let (value, end) = scan(word.as_bytes(), 0).unwrap();
        assert_eq!(end, word.len(), "{word}");
        narrow(value, word.as_bytes(), 0, end)
    }

    #[test]
    fn every_form_of_the_captures_is_read() {
        for (word, value) in [
            ("0", 0.0),
            ("12.5", 12.5),
            ("+12.5", 12.5),
            (".5", 0.5),
            ("5.", 5.0),
            ("-.5", -0.5),
            ("3.64024e-015", 3.64024e-15),
            ("-7.62852E-016", -7.62852e-16),
            ("1e5", 1e5),
            ("1e+005", 1e5),
            ("12345678901234567890123", 12345678901234567890123.0),
            ("0.00000000000000000000000000001234", 1.234e-29),
            ("9007199254740993", 9007199254740992.0),
            ("1e-999999999999999999999999", 0.0),
        ] {
            assert_eq!(parse(word.as_bytes()), Some(value), "{word}");
        }
        assert!(parse(b"-0").unwrap().is_sign_negative());
        assert!(parse(b"-0.000e-3").unwrap().is_sign_negative());
    }

    #[test]
    fn what_is_no_finite_number_is_refused() {
        for word in [
            "", "-", "+", ".", "-.", "e5", ".e5", "1e", "1e+", "nan", "inf", "-inf", "1e999", "12.5.1", "1,5", "1_000",
            "0x10", "1e5.0", "--1", "1 ", " 1", "1e400", "\u{ff11}",
        ] {
            assert_eq!(parse(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn flaws_are_told_apart() {
        for (word, expected) in [
            ("nan", NumberFlaw::NotFinite),
            ("-Infinity", NumberFlaw::NotFinite),
            ("-1.#IND", NumberFlaw::NotFinite),
            ("1e39", NumberFlaw::TooLarge),
            ("-1e999", NumberFlaw::TooLarge),
            ("93,500", NumberFlaw::DecimalComma),
            ("12.5.1", NumberFlaw::Malformed),
            ("1_0", NumberFlaw::Malformed),
            ("-", NumberFlaw::Malformed),
        ] {
            assert_eq!(parse_in_f32(word.as_bytes()), None);
            assert_eq!(flaw(word.as_bytes()), expected, "{word}");
        }
    }

    #[test]
    fn a_number_rounds_once_to_f32() {
        // The nearest f64 is half-way between two f32s; rounding that to even would miss the nearest f32.
        for word in
            ["7.038531e-26", "-7.038531e-26", "1.00000005960464477540", "1.00000017881393432617", "1e-45", "3e-42"]
        {
            assert_eq!(f32_of(word).to_bits(), word.parse::<f32>().unwrap().to_bits(), "{word}");
        }
    }

    fn same_as_the_oracles(word: &str) {
        let ours = scan(word.as_bytes(), 0).map(|(value, end)| (value.to_bits(), end));
        let oracle: f64 = fast_float2::parse(word).unwrap();
        if oracle.is_infinite() {
            assert_eq!(ours, None, "{word}");
            return;
        }
        assert_eq!(ours, Some((oracle.to_bits(), word.len())), "{word}");
        assert_eq!(word.parse::<f64>().unwrap().to_bits(), oracle.to_bits(), "{word}");
        assert_eq!(f32_of(word).to_bits(), word.parse::<f32>().unwrap().to_bits(), "{word}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn equals_fast_float_bit_for_bit(word in "-?[0-9]{1,24}(\\.[0-9]{0,24})?([eE][+-]?[0-9]{1,3})?") {
            same_as_the_oracles(&word);
        }

        #[test]
        fn equals_fast_float_on_what_captures_look_like(word in "-?[0-9]{1,3}\\.[0-9]{1,9}(e-0[0-9]{2})?") {
            same_as_the_oracles(&word);
        }

        #[test]
        fn a_written_f32_reads_back_bit_for_bit(bits in any::<u32>()) {
            let value = f32::from_bits(bits);
            prop_assume!(value.is_finite());
            let mut text = Vec::new();
            write_f32(&mut text, value);
            let text = String::from_utf8(text).unwrap();
            prop_assert_eq!(f32_of(&text).to_bits(), bits, "{}", &text);
            prop_assert!(!text.contains(['e', 'E']));
        }

        #[test]
        fn arbitrary_bytes_never_read_past_their_end(bytes in proptest::collection::vec(any::<u8>(), 0..40)) {
            if let Some((_, end)) = scan(&bytes, 0) {
                prop_assert!(end > 0 && end <= bytes.len());
            }
        }
    }
}
