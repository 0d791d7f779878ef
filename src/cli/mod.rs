//! Talks to people: arguments in, tables, progress and messages out. The only room that prints.
//!
//! Results go to standard output, progress and messages to standard error. Exit codes: 0 done; 2 arguments, config or
//! plan; 1 anything else that prevents or ends the work; 3 done with quarantined clips; 130 interrupted (resumable).
//!
//! One file a verb; `overview`, `distrust`, `faults`, `made`, `clip_page`, `strip`, `plot` and `pictures` are the parts of
//! `inspect`, `truths` and `evaluation` those of `evaluate`.

mod args;
mod check;
mod clip_page;
mod compact;
mod distrust;
mod evaluate;
mod evaluation;
mod export;
mod faults;
mod inspect;
mod made;
mod numbers;
mod output;
mod overview;
mod pictures;
mod plot;
mod progress;
mod raw;
mod run;
mod search;
mod strip;
mod synth;
mod table;
mod timeline;
mod truths;
mod verify;

use args::{Cli, Verb};
use clap::Parser;
use output::{Answer, Refusal, say, tell};
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
    crate::flow::guard::install_panic_hook(tell);
    let ending = match cli.verb {
        Verb::Run(args) => run::run(args),
        Verb::Inspect(args) => give(inspect::inspect(&args)),
        Verb::Search(args) => give(search::search(&args)),
        Verb::Export(args) => give(export::export(&args)),
        Verb::Synth(args) => synth::synth(&args),
        Verb::Evaluate(args) => give(evaluate::evaluate(&args)),
        Verb::Check(args) => give(check::check(&args)),
        Verb::Verify(args) => give(verify::verify(&args)),
        Verb::Compact(args) => compact::compact(&args),
    };
    ExitCode::from(match ending {
        Ending::Done => 0,
        Ending::Failed => 1,
        Ending::BadPlan => 2,
        Ending::Quarantined => 3,
        Ending::Interrupted => 130,
    })
}

/// Prints what a verb gave.
fn give(result: Result<Answer, Refusal>) -> Ending {
    match result {
        Ok(answer) => {
            say(&answer.text);
            answer.remarks.iter().for_each(|remark| tell(remark));
            answer.ending
        }
        Err(refusal) => {
            tell(&refusal.text);
            refusal.ending
        }
    }
}
