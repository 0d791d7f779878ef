//! Numbers as users read them.

use std::time::Duration;

/// With separators: `4,103,522`.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// With the separators of [`grouped`], of a count that may be very large.
pub(crate) fn grouped_text(digits: &str) -> String {
    digits.parse().map_or_else(|_| digits.to_owned(), grouped)
}

/// `1.4 GB`, `320.1 MB`, `38.0 MB`, `12.0 kB`.
pub(crate) fn bytes(count: u64) -> String {
    let count = count as f64;
    if count >= 1e9 {
        format!("{:.1} GB", count / 1e9)
    } else if count >= 0.1e6 {
        format!("{:.1} MB", count / 1e6)
    } else {
        format!("{:.1} kB", count / 1e3)
    }
}

/// `4 min 12 s`, `31 s`, `0.4 s`.
pub(crate) fn duration(time: Duration) -> String {
    let seconds = time.as_secs();
    match seconds {
        0..=9 => format!("{:.1} s", time.as_secs_f64()),
        10..=59 => format!("{seconds} s"),
        60..=3599 => format!("{} min {} s", seconds / 60, seconds % 60),
        _ => format!("{} h {} min", seconds / 3600, seconds / 60 % 60),
    }
}

/// `1 clip`, `2 clips`.
pub(crate) fn counted(number: u64, noun: &str) -> String {
    format!("{} {noun}{}", grouped(number), if number == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(4_103_522), "4,103,522");
        assert_eq!(grouped_text("38204118"), "38,204,118");
        assert_eq!(bytes(1_400_000_000), "1.4 GB");
        assert_eq!(bytes(38_000_000), "38.0 MB");
        assert_eq!(duration(Duration::from_millis(400)), "0.4 s");
        assert_eq!(duration(Duration::from_secs(252)), "4 min 12 s");
        assert_eq!(counted(1, "clip"), "1 clip");
        assert_eq!(counted(2541, "clip"), "2,541 clips");
    }
}
