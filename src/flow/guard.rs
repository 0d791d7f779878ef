//! Panics: one in the work on a clip is that clip's fault; any other ends the run with one line.
//!
//! timely does not end a process whose worker panics: the other workers wait for it for ever. So the hook exits.
//! Everything that was committed is safe, open shards are temporary files, and the same command continues.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    static WORKS_ON_A_CLIP: Cell<bool> = const { Cell::new(false) };
}

static PANICKED: AtomicBool = AtomicBool::new(false);

/// Installs the process' panic hook. `report` gets the one line that the user sees.
pub fn install_panic_hook(report: impl Fn(&str) + Send + Sync + 'static) {
    std::panic::set_hook(Box::new(move |info| {
        // Either is caught where it was called, and becomes an error.
        if WORKS_ON_A_CLIP.get() || crate::corpus::in_guarded_call() {
            return;
        }
        if PANICKED.swap(true, Ordering::SeqCst) {
            // The first one is being reported; the process is about to end.
            loop {
                std::thread::park();
            }
        }
        let what = payload_text(info.payload());
        let line = if what.starts_with("timely communication error:") {
            "error: another process of this run was lost".to_owned()
        } else {
            let place = info.location().map(|at| format!(" at {}:{}", at.file(), at.line())).unwrap_or_default();
            format!("error: a bug in motionmill{place}: {what}")
        };
        report(&format!(
            "{line}\n  try: the same command again; what was committed is safe, and it continues from there"
        ));
        std::process::exit(1);
    }));
}

/// Calls pure work on one clip; a panic in it comes back as its message.
pub fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    let before = WORKS_ON_A_CLIP.replace(true);
    let result = catch_unwind(AssertUnwindSafe(work));
    WORKS_ON_A_CLIP.set(before);
    result.map_err(|payload| payload_text(&*payload))
}

fn payload_text(payload: &(dyn Any + Send)) -> String {
    payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "a panic without words".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_in_the_work_on_a_clip_comes_back_as_its_message() {
        assert_eq!(guarded(|| 3), Ok(3));
        assert_eq!(guarded(|| -> i32 { panic!("frame {}", 7) }), Err("frame 7".to_owned()));
    }
}
