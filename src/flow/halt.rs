//! Why a run ends before its work is done, shared by everything in a process.

use serde::{Deserialize, Serialize};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// Why no more work is taken.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Halt {
    /// Somebody asked for it (Ctrl-C); what is in flight is finished and committed.
    Interrupted,
    /// Nothing can go on: disk full, no permission. The text says where, what, why and what to do.
    Fatal(String),
}

/// The process' flag, seen by the sources, which stop taking shards.
#[derive(Debug, Default)]
pub struct HaltFlag {
    interrupted: AtomicBool,
    fatal: OnceLock<String>,
}

impl HaltFlag {
    /// Asks for an orderly end. Answers false if it had been asked for before. Safe in a signal thread.
    pub fn interrupt(&self) -> bool {
        !self.interrupted.swap(true, Ordering::SeqCst)
    }

    /// Ends the run; the first fatal reason stays.
    pub fn halt(&self, halt: Halt) {
        match halt {
            Halt::Interrupted => self.interrupted.store(true, Ordering::SeqCst),
            Halt::Fatal(text) => {
                let _ = self.fatal.set(text);
            }
        }
    }

    /// Whether it ends for a reason that leaves no work trustworthy but what was committed.
    pub fn is_fatal(&self) -> bool {
        self.fatal.get().is_some()
    }

    /// The reason, if there is one.
    pub fn reason(&self) -> Option<Halt> {
        if let Some(text) = self.fatal.get() {
            return Some(Halt::Fatal(text.clone()));
        }
        self.interrupted.load(Ordering::SeqCst).then_some(Halt::Interrupted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_reason_stays_and_a_fatal_one_outweighs_an_interrupt() {
        let flag = HaltFlag::default();
        assert_eq!(flag.reason(), None);
        assert!(flag.interrupt());
        assert!(!flag.interrupt());
        assert_eq!(flag.reason(), Some(Halt::Interrupted));
        flag.halt(Halt::Fatal("disk full".into()));
        flag.halt(Halt::Fatal("later".into()));
        flag.halt(Halt::Interrupted);
        assert_eq!(flag.reason(), Some(Halt::Fatal("disk full".into())));
    }
}
