//! JSON files that tell when a byte of them has changed.
//!
//! The first line is `{"blake3": "<digest of the rest of the file>",`; the whole is one JSON object.

use super::error::CorpusError;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// A value as JSON under its own digest. Equal values give equal bytes.
pub(super) fn seal(value: &impl Serialize, path: &Path) -> Result<Vec<u8>, CorpusError> {
    let json = serde_json::to_string_pretty(value)
        .map_err(|error| CorpusError::Encoding { path: path.to_owned(), what: error.to_string() })?;
    // The value is a struct, so its text begins with `{` and a line end.
    let rest = format!("{}\n", json.strip_prefix("{\n").unwrap_or(&json));
    Ok(format!("{{\"blake3\": \"{}\",\n{rest}", blake3::hash(rest.as_bytes()).to_hex()).into_bytes())
}

/// The value in a file, if the file is as it was written.
pub(super) fn unseal<T: DeserializeOwned>(bytes: &[u8], path: &Path) -> Result<T, CorpusError> {
    let damaged = |what: &str| CorpusError::damaged(path, what);
    let text = std::str::from_utf8(bytes).map_err(|_| damaged("not text"))?;
    let (seal, rest) = text.split_once('\n').ok_or_else(|| damaged("cut short"))?;
    let digest = blake3::hash(rest.as_bytes()).to_hex();
    if seal != format!("{{\"blake3\": \"{digest}\",") {
        return Err(damaged("its digest is not that of its content"));
    }
    // The digest was right, so a value that can't be read was written by another version.
    serde_json::from_str(&format!("{{{rest}")).map_err(|error| damaged(&format!("not of this version: {error}")))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn any_flipped_bit_is_seen() {
        let value = BTreeMap::from([("a".to_owned(), 0.1f64), ("b".to_owned(), 1e-308)]);
        let path = Path::new("x.json");
        let bytes = seal(&value, path).unwrap();
        assert_eq!(unseal::<BTreeMap<String, f64>>(&bytes, path).unwrap(), value);
        let all: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
        assert_eq!(all["a"], 0.1);
        for bit in 0..bytes.len() * 8 {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(unseal::<BTreeMap<String, f64>>(&flipped, path).is_err(), "bit {bit}");
        }
        assert!(unseal::<BTreeMap<String, f64>>(b"", path).is_err());
    }
}
