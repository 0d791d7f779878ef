//! The file of the judge's reference: JSON under its own digest, as the manifest is.

use super::error::CorpusError;
use super::paths::REFERENCE;
use super::record::FileRecord;
use super::sealed::{seal, unseal};
use super::store::Store;
use crate::synthesis::judge::Reference;

/// Writes the reference; its rows are its layouts.
///
/// # Errors
/// The file system's refusals; the file is then as it was.
pub fn write_reference(store: &Store, reference: &Reference) -> Result<FileRecord, CorpusError> {
    let bytes = seal(reference, &store.path(REFERENCE))?;
    store.put_atomic(REFERENCE, &bytes)?;
    Ok(FileRecord {
        path: REFERENCE.to_owned(),
        bytes: bytes.len() as u64,
        blake3: blake3::hash(&bytes).to_hex().to_string(),
        rows: reference.n_layouts() as u64,
    })
}

/// Reads the reference.
///
/// # Errors
/// [`CorpusError::NotThere`] and [`CorpusError::Damaged`].
pub fn read_reference(store: &Store) -> Result<Reference, CorpusError> {
    let Some(bytes) = store.read(REFERENCE)? else {
        return Err(CorpusError::NotThere { what: REFERENCE.to_owned() });
    };
    let path = store.path(REFERENCE);
    let reference: Reference = unseal(&bytes, &path)?;
    match reference.is_sound() {
        true => Ok(reference),
        false => Err(CorpusError::damaged(&path, "not of this version, or its numbers are out of range")),
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn a_reference_reads_back_and_a_damaged_one_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        assert!(matches!(read_reference(&store), Err(CorpusError::NotThere { .. })));
        let file = write_reference(&store, &Reference::default()).unwrap();
        assert_eq!(read_reference(&store).unwrap(), Reference::default());
        let bytes = store.read(REFERENCE).unwrap().unwrap();
        assert_eq!((file.bytes, file.rows), (bytes.len() as u64, 0));
        for cut in 0..bytes.len() {
            store.put_atomic(REFERENCE, &bytes[..cut]).unwrap();
            assert!(matches!(read_reference(&store), Err(CorpusError::Damaged { .. })), "{cut} bytes");
        }
        // Sealed well, but of another version, or with a cell that there is not.
        let joint = serde_json::json!({"swing_cells": [65535], "twist_bins": [0, 1]});
        let layout = serde_json::json!({"captured_ms": 1, "joint_ranges": {"neck": joint}});
        for (version, layouts) in [(2, serde_json::json!({})), (1, serde_json::json!({"L1": layout}))] {
            let value = serde_json::json!({"layouts": layouts, "version": version});
            store.put_atomic(REFERENCE, &seal(&value, &store.path(REFERENCE)).unwrap()).unwrap();
            let error = read_reference(&store).unwrap_err();
            assert!(error.to_string().contains("out of range"), "{error}");
        }
    }
}
