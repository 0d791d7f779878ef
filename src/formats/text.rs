//! Lines and words of a text as bytes: LF, CRLF and a lone CR each end a line.

/// The UTF-8 byte order mark.
const BOM: &[u8] = b"\xef\xbb\xbf";

/// Where the text begins: behind a byte order mark.
pub(crate) fn text_start(bytes: &[u8]) -> usize {
    if bytes.starts_with(BOM) { BOM.len() } else { 0 }
}

/// Separates words within a line.
#[inline(always)]
pub(crate) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | 0x0b | 0x0c)
}

/// Ends a line.
#[inline(always)]
pub(crate) fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

/// Line (from 1) of the byte at `offset`. Counted only when a message needs it.
pub(crate) fn line_at(bytes: &[u8], offset: usize) -> u32 {
    let mut line = 1_u32;
    let mut after_cr = false;
    for &byte in &bytes[..offset.min(bytes.len())] {
        line = line.saturating_add(u32::from(byte == b'\r' || (byte == b'\n' && !after_cr)));
        after_cr = byte == b'\r';
    }
    line
}

/// The last line (from 1) with anything on it.
pub(crate) fn last_line(bytes: &[u8]) -> u32 {
    let last = bytes.iter().rposition(|&byte| !is_blank(byte) && !is_line_end(byte));
    line_at(bytes, last.unwrap_or(0))
}

/// First position from `at` on that holds no blank.
#[inline(always)]
pub(crate) fn skip_blanks(bytes: &[u8], mut at: usize) -> usize {
    while bytes.get(at).is_some_and(|&byte| is_blank(byte)) {
        at += 1;
    }
    at
}

/// Where the line that holds `at` ends: at its line end, or at the end of the bytes.
pub(crate) fn line_end(bytes: &[u8], at: usize) -> usize {
    bytes[at..].iter().position(|&byte| is_line_end(byte)).map_or(bytes.len(), |length| at + length)
}

/// Where the word that begins at `at` ends.
pub(crate) fn word_end(bytes: &[u8], at: usize) -> usize {
    bytes[at..].iter().position(|&byte| is_blank(byte) || is_line_end(byte)).map_or(bytes.len(), |length| at + length)
}

/// Words between blanks.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|&byte| is_blank(byte)).filter(|word| !word.is_empty())
}

/// Without blanks at either end.
pub(crate) fn trimmed(line: &[u8]) -> &[u8] {
    let from = line.iter().position(|&byte| !is_blank(byte)).unwrap_or(line.len());
    let to = line.iter().rposition(|&byte| !is_blank(byte)).map_or(from, |last| last + 1);
    &line[from..to]
}

/// As UTF-8, and whether it had to be repaired: then every byte above 127 is read as Latin-1, which loses nothing.
pub(crate) fn repaired(bytes: &[u8]) -> (String, bool) {
    match std::str::from_utf8(bytes) {
        Ok(text) => (text.to_owned(), false),
        Err(_) => (bytes.iter().map(|&byte| char::from(byte)).collect(), true),
    }
}

/// A piece of the file to quote in a message: at most 40 characters, nothing invisible.
pub(crate) fn excerpt(bytes: &[u8]) -> String {
    const MOST: usize = 40;
    let (text, _) = match bytes.get(..4 * MOST) {
        Some(long) => (String::from_utf8_lossy(long).into_owned(), true),
        None => repaired(bytes),
    };
    let visible = |c: char| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c };
    let mut quoted: String = text.chars().take(MOST).map(visible).collect();
    if text.chars().count() > MOST {
        quoted.push_str("...");
    }
    quoted
}

/// How the lines of a text end, as far as its first line tells: LF or CRLF.
pub(crate) fn first_line_end(text: &str) -> &'static str {
    match text.find('\n') {
        Some(at) if text[..at].ends_with('\r') => "\r\n",
        _ => "\n",
    }
}

/// Lines with their numbers (from 1), without their ends. A last line without an end counts.
pub(crate) struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u32,
}

impl<'a> Lines<'a> {
    /// The lines from `at` on, the first of which is numbered 1.
    pub(crate) fn new(bytes: &'a [u8], at: usize) -> Self {
        Lines { bytes, at, line: 0 }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u32, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.at >= self.bytes.len() {
            return None;
        }
        let from = self.at;
        let to = line_end(self.bytes, from);
        let crlf = self.bytes[to..].starts_with(b"\r\n");
        self.at = to + if crlf { 2 } else { 1 };
        self.line = self.line.saturating_add(1);
        Some((self.line, &self.bytes[from..to]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_line_end_counts_once() {
        let text = b"a\nb\r\nc\rd\n\ne";
        let lines: Vec<_> = Lines::new(text, 0).collect();
        let expected: Vec<(u32, &[u8])> = vec![(1, b"a"), (2, b"b"), (3, b"c"), (4, b"d"), (5, b""), (6, b"e")];
        assert_eq!(lines, expected);
        for (offset, byte) in text.iter().enumerate().filter(|(_, byte)| byte.is_ascii_lowercase()) {
            let line = expected.iter().find(|(_, line)| *line == [*byte]).map(|(number, _)| *number);
            assert_eq!(Some(line_at(text, offset)), line);
        }
        assert_eq!(last_line(b"a\nb\n  \n\n"), 2);
        assert_eq!(last_line(b""), 1);
    }

    #[test]
    fn a_quote_is_short_and_visible() {
        assert_eq!(excerpt(b"\0\0x"), "\u{fffd}\u{fffd}x");
        assert_eq!(excerpt(&[b'a'; 100]).len(), 43);
        assert_eq!(excerpt(b"gro\xdf"), "gro\u{df}");
    }
}
