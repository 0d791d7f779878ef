//! The clips and the enrich dataflow: shards in, committed tables out.
//!
//! ```text
//! desk -> shards -> read -> parse -> kinematics -> features -> contacts and gait -> write -> landed -> worker 0
//!                        -> make -> judge -^            faults of every stage -------^
//! ```
//!
//! One wiring serves both: a clip from a file passes through make and judge untouched, a recipe through read and parse.

use super::clip_stages;
use super::gauges::{Gauges, Station};
use super::halt::HaltFlag;
use super::lane::Lane;
use super::make_stages::Maker;
use super::per_clip::per_clip;
use super::settings::RunSettings;
use super::shard_source::{Flight, shard_source};
use super::shard_writer::{Landed, Landing, write_shards};
use super::tickets::open_desk;
use super::work::{ShardJob, Work};
use crate::corpus::{Catalog, ClipRow, Store};
use crate::synthesis::judge::Reference;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use timely::container::CapacityContainerBuilder;
use timely::dataflow::Stream;
use timely::dataflow::channels::pact::Exchange;
use timely::dataflow::operators::Probe;
use timely::dataflow::operators::generic::operator::Operator;
use timely::dataflow::operators::probe::Handle;
use timely::worker::Worker;

/// What a dataflow over shards works with, in one process.
#[derive(Clone)]
pub(crate) struct MillContext {
    pub(crate) store: Store,
    pub(crate) settings: Arc<RunSettings>,
    pub(crate) flag: Arc<HaltFlag>,
    pub(crate) gauges: Arc<Gauges>,
    /// The corpus as it was before this dataflow, where stored clips are read.
    pub(crate) catalog: Option<Catalog>,
    /// What made clips are judged by; empty where none are made.
    pub(crate) reference: Arc<Reference>,
}

/// Mills shards until none is left. Worker 0 gives the shards; it gets the sums of what landed, everywhere.
pub(crate) fn mill(worker: &mut Worker, shards: Vec<ShardJob>, context: &MillContext) -> Landed {
    let desk = open_desk(worker, shards, &context.flag);
    let flight = Rc::new(Flight::default());
    let probe = Handle::<Lane>::new();
    let landed = Rc::new(RefCell::new(Landed::default()));
    let parents: BTreeMap<u32, ClipRow> =
        context.catalog.iter().flat_map(|catalog| catalog.clips().map(|row| (row.clip_id, row.clone()))).collect();
    let landing = Landing {
        store: context.store.clone(),
        settings: Arc::clone(&context.settings),
        flight: Rc::clone(&flight),
        flag: Arc::clone(&context.flag),
        gauges: Arc::clone(&context.gauges),
        parents: Arc::new(parents),
    };
    worker.dataflow::<Lane, _, _>(|scope| {
        let shards = shard_source(scope, desk, flight, Arc::clone(&context.flag), Arc::clone(&context.gauges));
        let settings = || Arc::clone(&context.settings);
        let gauges = || Arc::clone(&context.gauges);

        let (told, catalog, counted) = (settings(), context.catalog.clone(), gauges());
        let (clips, read_faults) = per_clip(shards, Station::Read, gauges(), move |work: &mut Work| {
            clip_stages::read(work, &told)?;
            counted.bytes.fetch_add(work.text.motion.len() as u64, std::sync::atomic::Ordering::Relaxed);
            Ok(())
        });
        let told = settings();
        let (clips, parse_faults) =
            per_clip(clips, Station::Parse, gauges(), move |work| clip_stages::parse(work, &told, catalog.as_ref()));
        let maker = Maker::new(context.catalog.clone(), settings(), Arc::clone(&context.reference));
        let maker = Rc::new(RefCell::new(maker));
        let judge = Rc::clone(&maker);
        let (clips, make_faults) = per_clip(clips, Station::Make, gauges(), move |work| maker.borrow_mut().make(work));
        let (clips, judge_faults) =
            per_clip(clips, Station::Judge, gauges(), move |work| judge.borrow_mut().judge(work));
        let told = settings();
        let (clips, kinematics_faults) =
            per_clip(clips, Station::Kinematics, gauges(), move |work| clip_stages::kinematics(work, &told));
        let told = settings();
        let (clips, features_faults) = per_clip(clips, Station::Features, gauges(), move |work| {
            clip_stages::features(work, &told);
            Ok(())
        });
        let told = settings();
        let (clips, contacts_faults) = per_clip(clips, Station::Contacts, gauges(), move |work| {
            clip_stages::contacts(work, &told);
            Ok(())
        });
        let faults =
            [read_faults, parse_faults, make_faults, judge_faults, kinematics_faults, features_faults, contacts_faults];
        let faults = timely::dataflow::operators::core::Concatenate::concatenate(&scope, faults);
        to_worker_0(write_shards(clips, faults, landing), &landed, &probe);
    });
    while !probe.done() {
        worker.step_or_park(None);
    }
    landed.take()
}

fn to_worker_0(landings: Stream<'_, Lane, Vec<Landed>>, sum: &Rc<RefCell<Landed>>, probe: &Handle<Lane>) {
    let sum = Rc::clone(sum);
    landings
        .unary::<CapacityContainerBuilder<Vec<()>>, _, _, _>(Exchange::new(|_: &Landed| 0), "Landed", move |_, _| {
            move |input, _| {
                input.for_each_stamp(|_, batch| {
                    let mut sum = sum.borrow_mut();
                    for landed in batch.flat_map(|batch| batch.drain(..)) {
                        sum.clips += landed.clips;
                        sum.frames += landed.frames;
                        sum.faults += landed.faults;
                    }
                });
            }
        })
        .probe_with(probe);
}
