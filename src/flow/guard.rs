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
        if what.starts_with("failed printing to std") {
            std::process::exit(0); // nobody reads any more: a closed pipe ends quietly
        }
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
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn a_panic_in_the_work_on_a_clip_comes_back_as_its_message() {
        assert_eq!(guarded(|| 3), Ok(3));
        assert_eq!(guarded(|| -> i32 { panic!("frame {}", 7) }), Err("frame 7".to_owned()));
    }

    const AS_CHILD: &str = "MOTIONMILL_TEST_PANICS";

    /// Two workers, of which one panics; the other would wait for it for ever. Runs in a child process.
    #[test]
    fn a_panic_of_a_worker_ends_the_process() {
        if std::env::var_os(AS_CHILD).is_some() {
            install_panic_hook(|line| eprintln!("{line}"));
            let guards = timely::execute(timely::Config::process(2), |worker| {
                assert_ne!(worker.index(), 1, "a bug of ours");
                crate::flow::agree::agree(worker, &crate::flow::halt::HaltFlag::default())
            });
            drop(guards);
            return;
        }
        let name = "flow::guard::tests::a_panic_of_a_worker_ends_the_process";
        let mut child = std::process::Command::new(std::env::current_exe().unwrap())
            .args([name, "--exact", "--nocapture"])
            .env(AS_CHILD, "1")
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        let start = std::time::Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            if start.elapsed().as_secs() > 60 {
                child.kill().unwrap();
                panic!("the process hangs");
            }
            std::thread::sleep(std::time::Duration::from_millis(20));
        };
        let mut said = String::new();
        std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut said).unwrap();
        assert_eq!(status.code(), Some(1), "{said}");
        assert_eq!(said.matches("error: a bug in motionmill").count(), 1, "{said}");
        assert!(said.contains("a bug of ours"), "{said}");
    }
}
