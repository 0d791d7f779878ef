//! Takes shards from the desk and emits their clips, one an activation, never more than the writer can follow.

use super::gauges::Gauges;
use super::halt::HaltFlag;
use super::lane::Lane;
use super::tickets::Desk;
use super::work::{ShardJob, Work};
use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use timely::container::CapacityContainerBuilder;
use timely::dataflow::operators::Capability;
use timely::dataflow::operators::generic::operator::source;
use timely::dataflow::{Scope, Stream};
use timely::scheduling::Activator;

/// Shards that a worker may have open.
const SHARDS_IN_FLIGHT: usize = 2;
/// Clips of a worker between source and writer: one at work, one behind it.
const CLIPS_IN_FLIGHT: usize = 2;
/// Shards asked for ahead, so that the desk's answer is there when it is needed.
const REQUESTS_AHEAD: usize = 2;

/// What is under way on one worker: raised by its source, lowered by its writer. Both sit on this worker and
/// nothing leaves it between them (`Pipeline` throughout), so a `Cell` is enough.
#[derive(Default)]
pub(crate) struct Flight {
    pub(crate) shards: Cell<usize>,
    pub(crate) clips: Cell<usize>,
    source: RefCell<Option<Activator>>,
}

impl Flight {
    /// Wakes the source, after something has landed.
    pub(crate) fn wake_source(&self) {
        if let Some(source) = &*self.source.borrow() {
            source.activate();
        }
    }
}

struct State {
    capability: Option<Capability<Lane>>,
    worker: u32,
    taken: u64,
    open: Option<(Arc<ShardJob>, usize)>,
    told: bool,
}

/// The clips of the shards that this worker gets from the desk.
pub(crate) fn shard_source<'scope>(
    scope: Scope<'scope, Lane>,
    desk: Rc<RefCell<Desk>>,
    flight: Rc<Flight>,
    flag: Arc<HaltFlag>,
    gauges: Arc<Gauges>,
) -> Stream<'scope, Lane, Vec<Work>> {
    source::<_, CapacityContainerBuilder<Vec<Work>>, _, _>(scope, "Shards", move |mut capability, info| {
        let me = scope.activator_for(info.address.clone());
        *flight.source.borrow_mut() = Some(scope.activator_for(info.address.clone()));
        desk.borrow_mut().wake(scope.activator_for(info.address));
        let worker = scope.index() as u32;
        // At once, or nobody's frontier moves.
        capability.downgrade(&Lane::At(worker, 0));
        me.activate();
        let mut state = State { capability: Some(capability), worker, taken: 0, open: None, told: false };
        move |output| {
            let Some(capability) = &mut state.capability else { return };
            if let Some(halt) = flag.reason().filter(|_| !state.told) {
                state.told = true;
                desk.borrow_mut().halt(halt);
            }
            while desk.borrow().open_requests() < REQUESTS_AHEAD {
                desk.borrow_mut().ask();
            }
            if let Some((shard, next)) = &mut state.open {
                if flight.clips.get() >= CLIPS_IN_FLIGHT {
                    return; // the writer wakes us
                }
                output.session(&capability).give(Work::new(Arc::clone(shard), state.taken, *next));
                flight.clips.set(flight.clips.get() + 1);
                *next += 1;
                if *next == shard.clips.len() {
                    state.open = None;
                    state.taken += 1;
                    capability.downgrade(&Lane::At(state.worker, state.taken));
                }
                me.activate();
                return;
            }
            if state.told {
                // What is in flight ends; nothing more is taken, nor waited for.
                state.capability = None;
                desk.borrow_mut().leave();
                return;
            }
            if flight.shards.get() >= SHARDS_IN_FLIGHT {
                return; // the writer wakes us
            }
            let answer = desk.borrow_mut().take();
            match answer {
                None => {} // the inbox wakes us
                Some(Some(shard)) if !shard.clips.is_empty() => {
                    flight.shards.set(flight.shards.get() + 1);
                    gauges.beats.fetch_add(1, Ordering::Relaxed);
                    state.open = Some((Arc::new(shard), 0));
                    me.activate(); // return before working: progress leaves a worker only then
                }
                Some(Some(_)) => me.activate(),
                Some(None) => {
                    state.capability = None;
                    desk.borrow_mut().leave();
                }
            }
        }
    })
}
