//! The ticket desk: worker 0 hands out shards to whoever asks, in any process.
//!
//! ```text
//! ask (every worker) --exchange to worker 0--> desk (the queue) --exchange back--> inbox of the asker
//! ```
//!
//! Shards differ in cost, so none belongs to a worker beforehand; what a shard holds and how it is called were
//! fixed before any work, so who mills it changes nothing. A reason to halt is one more request: it empties the
//! queue, and everybody learns of it with the next answer.

use super::halt::{Halt, HaltFlag};
use super::work::ShardJob;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;
use timely::container::CapacityContainerBuilder;
use timely::dataflow::channels::pact::Exchange;
use timely::dataflow::operators::generic::operator::Operator;
use timely::dataflow::operators::vec::Input;
use timely::dataflow::operators::vec::input::Handle;
use timely::scheduling::Activator;
use timely::worker::Worker;

#[derive(Clone, Debug, Serialize, Deserialize)]
enum Request {
    Shard { worker: u64 },
    Halt(Halt),
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Answer {
    worker: u64,
    shard: Option<ShardJob>,
    halt: Option<Halt>,
}

/// A worker's place at the desk. Shared by the shard source and the operator that fills the inbox, which is
/// sound because both live on this worker.
pub(crate) struct Desk {
    worker: u64,
    input: Option<Handle<u64, Request>>,
    /// Answers that have come: a shard, or none left.
    inbox: VecDeque<Option<ShardJob>>,
    awaited: usize,
    wake: Option<Activator>,
}

impl Desk {
    /// Asks for another shard.
    pub(crate) fn ask(&mut self) {
        let worker = self.worker;
        self.send(Request::Shard { worker });
        self.awaited += 1;
    }

    /// Tells everybody to take no more.
    pub(crate) fn halt(&mut self, halt: Halt) {
        self.send(Request::Halt(halt));
    }

    /// Shards asked for and not yet taken.
    pub(crate) fn open_requests(&self) -> usize {
        self.awaited + self.inbox.len()
    }

    /// An answer, if one has come: a shard, or `Some(None)` when none is left.
    pub(crate) fn take(&mut self) -> Option<Option<ShardJob>> {
        self.inbox.pop_front()
    }

    /// Leaves the desk: no further requests.
    pub(crate) fn leave(&mut self) {
        self.input = None;
    }

    /// Who is to be woken when an answer comes.
    pub(crate) fn wake(&mut self, activator: Activator) {
        self.wake = Some(activator);
    }

    fn send(&mut self, request: Request) {
        if let Some(input) = &mut self.input {
            input.send(request);
            // A flush alone does not push through an exchange; an advance does.
            let next = input.time() + 1;
            input.advance_to(next);
        }
    }
}

/// Opens the desk as a dataflow of its own. `shards` is what worker 0 hands out; the others' is ignored.
pub(crate) fn open_desk(worker: &mut Worker, shards: Vec<ShardJob>, flag: &Arc<HaltFlag>) -> Rc<RefCell<Desk>> {
    let index = worker.index() as u64;
    let mut queue: VecDeque<ShardJob> = if index == 0 { shards.into() } else { VecDeque::new() };
    let flag = Arc::clone(flag);
    worker.dataflow::<u64, _, _>(|scope| {
        let (input, requests) = scope.new_input::<Request>();
        let desk = Rc::new(RefCell::new(Desk {
            worker: index,
            input: Some(input),
            inbox: VecDeque::new(),
            awaited: 0,
            wake: None,
        }));
        let at_desk = Rc::clone(&desk);
        let mut halted: Option<Halt> = None;
        requests
            .unary::<CapacityContainerBuilder<Vec<Answer>>, _, _, _>(
                Exchange::new(|_: &Request| 0),
                "TicketDesk",
                move |_, _| {
                    move |input, output| {
                        input.for_each_stamp(|capability, requests| {
                            let mut session = output.session(&capability);
                            for request in requests.flat_map(|batch| batch.drain(..)) {
                                match request {
                                    Request::Shard { worker } => {
                                        let shard = queue.pop_front();
                                        session.give(Answer { worker, shard, halt: halted.clone() });
                                    }
                                    Request::Halt(halt) => {
                                        queue.clear();
                                        halted.get_or_insert(halt);
                                    }
                                }
                            }
                        });
                    }
                },
            )
            .sink(Exchange::new(|answer: &Answer| answer.worker), "TicketInbox", move |(input, _)| {
                input.for_each_stamp(|_, answers| {
                    let mut desk = at_desk.borrow_mut();
                    for answer in answers.flat_map(|batch| batch.drain(..)) {
                        if let Some(halt) = answer.halt {
                            flag.halt(halt);
                        }
                        desk.awaited = desk.awaited.saturating_sub(1);
                        desk.inbox.push_back(answer.shard);
                    }
                    if let Some(wake) = &desk.wake {
                        wake.activate();
                    }
                });
            });
        desk
    })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::corpus::{ShardId, StageKeys};
    use crate::flow::work::Todo;
    use timely::Config;

    fn shards(n: u32) -> Vec<ShardJob> {
        let shard = |number| ShardJob {
            shard: ShardId::captured(number),
            replaces: Vec::new(),
            todo: Todo::Everything,
            keys: StageKeys::default(),
            clips: Vec::new(),
        };
        (0..n).map(shard).collect()
    }

    /// Takes shards until none is left; after `halt_after` of them this worker asks for the end.
    fn take_all(worker: &mut Worker, n_shards: u32, halt_after: usize) -> (Vec<ShardId>, Option<Halt>) {
        let flag = Arc::new(HaltFlag::default());
        // Only worker 0's list counts.
        let desk = open_desk(worker, shards(n_shards + worker.index() as u32), &flag);
        let mut taken = Vec::new();
        desk.borrow_mut().ask();
        loop {
            let answer = desk.borrow_mut().take();
            match answer {
                Some(Some(shard)) => {
                    taken.push(shard.shard);
                    if taken.len() == halt_after {
                        desk.borrow_mut().halt(Halt::Interrupted);
                    }
                    desk.borrow_mut().ask();
                }
                Some(None) => break,
                None => {
                    worker.step_or_park(Some(std::time::Duration::from_millis(1)));
                }
            }
        }
        desk.borrow_mut().leave();
        (taken, flag.reason())
    }

    #[test]
    fn every_shard_is_given_to_exactly_one_worker() {
        for workers in 1..=3 {
            let guards = timely::execute(Config::process(workers), |worker| take_all(worker, 40, usize::MAX)).unwrap();
            let answers: Vec<_> = guards.join().into_iter().map(Result::unwrap).collect();
            assert!(answers.iter().all(|(_, halt)| halt.is_none()));
            let mut all: Vec<ShardId> = answers.into_iter().flat_map(|(taken, _)| taken).collect();
            all.sort();
            assert_eq!(all, (0..40).map(ShardId::captured).collect::<Vec<_>>(), "{workers} workers");
        }
    }

    #[test]
    fn a_halt_empties_the_queue_and_all_hear_of_it() {
        for workers in 1..=3 {
            let guards = timely::execute(Config::process(workers), |worker| take_all(worker, 10_000, 5)).unwrap();
            for answer in guards.join() {
                let (taken, halt) = answer.unwrap();
                assert!(taken.len() < 10_000);
                assert_eq!(halt, Some(Halt::Interrupted), "{workers} workers");
            }
        }
    }
}
