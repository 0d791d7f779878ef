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

/// The process' flag: set once, seen by the sources, which stop taking shards.
#[derive(Debug, Default)]
pub struct HaltFlag {
    interrupted: AtomicBool,
    halt: OnceLock<Halt>,
}

impl HaltFlag {
    /// Asks for an orderly end. Answers false if it had been asked for before. Safe in a signal thread.
    pub fn interrupt(&self) -> bool {
        !self.interrupted.swap(true, Ordering::SeqCst)
    }

    /// Ends the run; the first reason stays.
    pub fn halt(&self, halt: Halt) {
        let _ = self.halt.set(halt);
    }

    /// The reason, if there is one.
    pub fn reason(&self) -> Option<Halt> {
        if let Some(halt) = self.halt.get() {
            return Some(halt.clone());
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
        assert_eq!(flag.reason(), Some(Halt::Fatal("disk full".into())));
    }
}
