//! Talks to people: arguments in, tables, progress and messages out. The only room that prints.
//!
//! Results go to standard output, progress and messages to standard error. Exit codes: 0 done; 2 arguments, config or
//! plan; 1 anything else that prevents or ends the work; 3 done with quarantined clips; 130 interrupted (resumable).

mod args;
mod numbers;
mod overview;
mod progress;
mod run;
mod synth;

use args::{Cli, Verb};
use clap::Parser;
use std::process::ExitCode;

/// How a verb ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ending {
    Done,
    Failed,
    BadPlan,
    Quarantined,
    Interrupted,
}

/// Runs the program.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    crate::flow::guard::install_panic_hook(|line| eprintln!("{line}"));
    let ending = match cli.verb {
        Verb::Run(args) => run::run(args),
        Verb::Synth(args) => synth::synth(&args),
    };
    ExitCode::from(match ending {
        Ending::Done => 0,
        Ending::Failed => 1,
        Ending::BadPlan => 2,
        Ending::Quarantined => 3,
        Ending::Interrupted => 130,
    })
}
