//! Where the shared captures and references lie. Absent: the caller's test is skipped aloud, or fails when `CI` is set.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The folder `../shared` beside the checkout.
pub(crate) fn shared() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    if folder.join("DESIGN.md").exists() {
        return Some(folder);
    }
    assert!(std::env::var_os("CI").is_none(), "CI is set, but ../shared is not there");
    eprintln!("skipped: ../shared is not there");
    None
}

/// The folder with `bandai-namco`, `cmu` and `extra` unpacked.
pub(crate) fn captures() -> Option<PathBuf> {
    static CAPTURES: OnceLock<Option<PathBuf>> = OnceLock::new();
    CAPTURES
        .get_or_init(|| {
            let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/data");
            let status = Command::new("sh").arg(shared()?.join("data/unpack.sh")).arg(&data).output().unwrap();
            assert!(status.status.success(), "unpack.sh failed: {}", String::from_utf8_lossy(&status.stderr));
            Some(data)
        })
        .clone()
}

/// The text of a reference of the oracle, unpacked.
pub(crate) fn reference(name: &str) -> Option<String> {
    let file = shared()?.join("oracle/reference").join(name);
    let output = Command::new("xz").arg("-dc").arg(&file).output().unwrap();
    assert!(output.status.success(), "xz -dc {} failed", file.display());
    Some(String::from_utf8(output.stdout).unwrap())
}

/// The Python that has the peers (numpy, scipy, duckdb, polars, pandas, pyarrow): `MOTIONMILL_PEERS_PYTHON`, which `.ci/run` sets.
pub(crate) fn peers_python() -> Option<std::ffi::OsString> {
    let python = std::env::var_os("MOTIONMILL_PEERS_PYTHON");
    if python.is_none() {
        assert!(std::env::var_os("CI").is_none(), "CI is set, but MOTIONMILL_PEERS_PYTHON is not");
        eprintln!("skipped: MOTIONMILL_PEERS_PYTHON names no Python with the packages of .ci/run");
    }
    python
}
