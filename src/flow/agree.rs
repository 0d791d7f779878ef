//! A point that every worker, in every process, must have reached before any goes on, and where all learn whether one of
//! them wants the run to end. Between two dataflows nobody may leave alone: the others would wait for it for ever.

use super::halt::{Halt, HaltFlag};
use std::cell::RefCell;
use std::rc::Rc;
use timely::container::CapacityContainerBuilder;
use timely::dataflow::channels::pact::Pipeline;
use timely::dataflow::operators::Probe;
use timely::dataflow::operators::generic::operator::Operator;
use timely::dataflow::operators::probe::Handle;
use timely::dataflow::operators::vec::{Broadcast, Input};
use timely::worker::Worker;

/// Waits until all workers are here. All get the same answer, whatever their processes' flags say a moment later: why
/// the run ends, if it does. A fatal reason comes before an interrupt, then the lowest worker's; the flag has it too.
pub(crate) fn agree(worker: &mut Worker, flag: &HaltFlag) -> Option<Halt> {
    let probe = Handle::<u64>::new();
    let reasons = Rc::new(RefCell::new(Vec::<(usize, Halt)>::new()));
    let heard = Rc::clone(&reasons);
    let mut input = worker.dataflow::<u64, _, _>(|scope| {
        let (input, stream) = scope.new_input::<(usize, Halt)>();
        stream
            .broadcast()
            .unary::<CapacityContainerBuilder<Vec<()>>, _, _, _>(Pipeline, "Agree", move |_, _| {
                move |input, _| {
                    input.for_each_stamp(|_, said| heard.borrow_mut().extend(said.flat_map(|batch| batch.drain(..))));
                }
            })
            .probe_with(&probe);
        input
    });
    if let Some(halt) = flag.reason() {
        input.send((worker.index(), halt));
    }
    input.close();
    while !probe.done() {
        worker.step_or_park(None);
    }
    let reasons = std::mem::take(&mut *reasons.borrow_mut());
    let agreed = reasons.into_iter().min_by_key(|(index, halt)| (*halt == Halt::Interrupted, *index));
    let (_, halt) = agreed?;
    flag.halt(halt.clone());
    Some(halt)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use std::sync::Arc;

    #[test]
    fn what_one_worker_says_all_workers_hear() {
        for workers in 1..=3 {
            let guards = timely::execute(timely::Config::process(workers), |worker| {
                // As many processes would: a flag each.
                let flag = Arc::new(HaltFlag::default());
                let first = agree(worker, &flag);
                if worker.index() == worker.peers() - 1 {
                    flag.halt(Halt::Fatal("disk full".to_owned()));
                } else {
                    flag.interrupt();
                }
                (first, agree(worker, &flag), flag.reason())
            });
            for answer in guards.unwrap().join() {
                let halt = Some(Halt::Fatal("disk full".to_owned()));
                assert_eq!(answer.unwrap(), (None, halt.clone(), halt), "{workers} workers");
            }
        }
    }
}
