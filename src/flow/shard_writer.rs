//! The end of the clips and the enrich dataflow: clips become rows of a shard's tables; once the shard's time has passed,
//! files and record are put in place, and the source hears that there is room again.

use super::gauges::{Gauges, Station};
use super::halt::{Halt, HaltFlag};
use super::lane::Lane;
use super::settings::RunSettings;
use super::shard_source::Flight;
use super::work::{ClipJob, ClipOrigin, Faulted, ShardJob, Todo, Work};
use crate::corpus::{
    ClipFormat, ClipRow, ClipTables, CorpusError, FaultRow, InputFile, Origin, ShardKind, ShardRecord, ShardWriter,
    SkeletonRow, Store, read_record,
};
use crate::motion::bounds::median_bone_lengths_mm;
use crate::motion::{Format, Notice, Severity};
use crate::synthesis::Made;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;
use timely::container::CapacityContainerBuilder;
use timely::dataflow::Stream;
use timely::dataflow::channels::pact::Pipeline;
use timely::dataflow::operators::CapabilitySet;
use timely::dataflow::operators::generic::operator::Operator;

/// A shard that is committed, for the sink on worker 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Landed {
    pub(crate) clips: u32,
    pub(crate) frames: u64,
    pub(crate) faults: u32,
}

/// What the writer works with.
#[derive(Clone)]
pub(crate) struct Landing {
    pub(crate) store: Store,
    pub(crate) settings: Arc<RunSettings>,
    pub(crate) flight: Rc<Flight>,
    pub(crate) flag: Arc<HaltFlag>,
    pub(crate) gauges: Arc<Gauges>,
    /// Rows of clips that made clips take license and subject from.
    pub(crate) parents: Arc<BTreeMap<u32, ClipRow>>,
}

struct OpenShard {
    job: Arc<ShardJob>,
    capability: CapabilitySet<Lane>,
    writer: ShardWriter,
    record: ShardRecord,
    notices: BTreeMap<usize, Vec<Notice>>,
    made: BTreeMap<usize, Made>,
}

/// Writes clips and commits shards; emits what landed.
pub(crate) fn write_shards<'scope>(
    clips: Stream<'scope, Lane, Vec<Work>>,
    faults: Stream<'scope, Lane, Vec<Faulted>>,
    landing: Landing,
) -> Stream<'scope, Lane, Vec<Landed>> {
    clips.binary_frontier::<_, CapacityContainerBuilder<Vec<Landed>>, _, _, _, _>(
        faults,
        Pipeline,
        Pipeline,
        "write",
        move |_, _| {
            let mut open = BTreeMap::<u64, OpenShard>::new();
            move |(clips, clips_left), (faults, faults_left), output| {
                clips.for_each_stamp(|capability, batch| {
                    for work in batch.flat_map(|batch| batch.drain(..)) {
                        let start = Instant::now();
                        let written = open_shard(&mut open, &work.shard, work.taken, &landing)
                            .and_then(|shard| shard.take(capability.retain_stamp(0), work, &landing));
                        landing.landed_clip(Station::Write, start);
                        landing.or_halt(written);
                    }
                });
                faults.for_each_stamp(|capability, batch| {
                    for faulted in batch.flat_map(|batch| batch.drain(..)) {
                        let start = Instant::now();
                        match open_shard(&mut open, &faulted.shard, faulted.taken, &landing) {
                            Ok(shard) => shard.take_faulted(capability.retain_stamp(0), faulted, &landing),
                            Err(error) => landing.or_halt(Err(error)),
                        }
                        landing.landed_clip(Station::Write, start);
                    }
                });
                let worker_time = |taken: u64, shard: &OpenShard| {
                    shard.capability.iter().any(|capability| {
                        let time = capability.time();
                        debug_assert!(matches!(time, Lane::At(_, n) if *n == taken), "a shard holds its own time");
                        clips_left.frontier().less_equal(time) || faults_left.frontier().less_equal(time)
                    })
                };
                let passed: Vec<u64> = open
                    .iter()
                    .filter(|&(&taken, shard)| !worker_time(taken, shard))
                    .map(|(&taken, _)| taken)
                    .collect();
                for taken in passed {
                    let Some(shard) = open.remove(&taken) else { continue };
                    let start = Instant::now();
                    let capability = shard.capability.clone();
                    landing.flight.shards.set(landing.flight.shards.get() - 1);
                    landing.flight.wake_source();
                    if landing.flag.is_fatal() {
                        continue; // it may lack the clip whose writing failed
                    }
                    let committed = shard.commit();
                    landing.gauges.spent(Station::Write, start.elapsed());
                    match committed {
                        Ok(landed) => {
                            landing.gauges.shards.fetch_add(1, Ordering::Relaxed);
                            output.session(&capability).give(landed);
                        }
                        Err(error) => landing.or_halt(Err(error)),
                    }
                }
            }
        },
    )
}

fn open_shard<'a>(
    open: &'a mut BTreeMap<u64, OpenShard>,
    job: &Arc<ShardJob>,
    taken: u64,
    landing: &Landing,
) -> Result<&'a mut OpenShard, CorpusError> {
    use std::collections::btree_map::Entry;
    match open.entry(taken) {
        Entry::Occupied(entry) => Ok(entry.into_mut()),
        Entry::Vacant(entry) => {
            let record = match job.todo {
                Todo::Everything | Todo::Samples { .. } => {
                    ShardRecord { replaces: job.replaces.clone(), ..ShardRecord::new(job.shard) }
                }
                Todo::Again { .. } => read_record(&landing.store, job.shard)?
                    .ok_or_else(|| CorpusError::NotThere { what: job.shard.record_file() })?,
            };
            let settings = landing.settings.shard_settings(job.todo, job.shard.kind == ShardKind::Made);
            Ok(entry.insert(OpenShard {
                job: Arc::clone(job),
                capability: CapabilitySet::new(),
                writer: ShardWriter::create(&landing.store, job.shard, settings),
                record,
                notices: BTreeMap::new(),
                made: BTreeMap::new(),
            }))
        }
    }
}

impl Landing {
    fn or_halt(&self, result: Result<(), CorpusError>) {
        if let Err(error) = result {
            self.flag.halt(Halt::Fatal(fatal_text(&error)));
        }
    }

    fn landed_clip(&self, station: Station, start: Instant) {
        self.gauges.spent(station, start.elapsed());
        self.gauges.clips_done.fetch_add(1, Ordering::Relaxed);
        self.flight.clips.set(self.flight.clips.get() - 1);
        self.flight.wake_source();
    }
}

impl OpenShard {
    fn take(&mut self, capability: CapabilitySet<Lane>, work: Work, landing: &Landing) -> Result<(), CorpusError> {
        self.capability = capability;
        let job = work.job().clone();
        let clip = Arc::clone(work.clip());
        landing.gauges.frames.fetch_add(clip.n_frames as u64, Ordering::Relaxed);
        let outcome = work.outcome.as_ref();
        let pushed = self.writer.push(&ClipTables {
            clip_id: job.clip_id,
            n_frames: clip.n_frames,
            rate_hz: clip.rate_hz,
            skeleton: &clip.skeleton,
            roles: &work.roles,
            channels: Some(&clip.channels),
            poses: work.poses.as_ref(),
            rotations: work.rotations.as_ref(),
            labels: Some(&work.annotated.frames).filter(|frames| !frames.time_s.is_empty()),
            features: Some(&work.features),
            plants: &work.annotated.plants,
            segments: &work.annotated.segments,
            provenance: outcome.map_or(&[][..], |outcome| &outcome.provenance),
        });
        let mut notices = work.notices.clone();
        match pushed {
            Ok(()) => {}
            // The tables would not have it (a number that isn't finite): its fault, nobody else's.
            Err(CorpusError::Refused { what, .. }) => {
                notices.push(refused(what));
                self.note_input(&job);
                self.notices.insert(work.index, notices);
                landing.gauges.faults.fetch_add(1, Ordering::Relaxed);
                return Ok(());
            }
            Err(error) => return Err(error),
        }
        match job.origin {
            ClipOrigin::Stored => {
                if let Some(row) = self.record.clips.iter_mut().find(|row| row.clip_id == job.clip_id)
                    && matches!(self.job.todo, Todo::Again { labels: true, .. })
                {
                    row.labels = work.annotated.clip;
                }
            }
            ClipOrigin::Kept(ref kept) => {
                self.skeleton_of(&work);
                self.note_input(&job);
                self.record.clips.extend(kept.row.clone().map(|row| ClipRow { labels: work.annotated.clip, ..row }));
            }
            ClipOrigin::File(ref file) => {
                let skeleton = self.skeleton_of(&work);
                let row = ClipRow {
                    format: match clip.skeleton.format {
                        Format::Bvh => ClipFormat::Bvh,
                        Format::Amc => ClipFormat::Amc,
                    },
                    subject: file.settings.subject.clone(),
                    frame_time_s: work.facts.frame_time_s,
                    max_rounding: work.facts.max_rounding,
                    licenses: file.settings.license.iter().cloned().collect(),
                    attribution: file.settings.attribution.clone(),
                    may_share: file.settings.may_share,
                    may_sell: file.settings.may_sell,
                    origin: if file.procedural { Origin::Procedural } else { Origin::Captured },
                    warnings: notices.iter().filter(|notice| notice.severity == Severity::Warning).count() as u32,
                    ..plain_row(&job, &work, skeleton)
                };
                self.note_input(&job);
                self.record.clips.push(row);
            }
            ClipOrigin::Recipe(ref recipe) => {
                let skeleton = self.skeleton_of(&work);
                let parents: Vec<&ClipRow> =
                    [recipe.base, recipe.donor].iter().filter_map(|parent| landing.parents.get(parent)).collect();
                let row = ClipRow {
                    parents: vec![recipe.base, recipe.donor],
                    recipe: Some(recipe.recipe.recipe.clone()),
                    max_rounding: parents.first().map_or(0.0, |base| base.max_rounding),
                    frame_time_s: parents.first().and_then(|base| base.frame_time_s),
                    ..terms_of(plain_row(&job, &work, skeleton), &parents)
                };
                self.record.clips.push(row);
            }
        }
        if let Some(outcome) = work.outcome {
            self.made.insert(work.index, outcome.made);
        }
        self.notices.insert(work.index, notices);
        Ok(())
    }

    fn take_faulted(&mut self, capability: CapabilitySet<Lane>, faulted: Faulted, landing: &Landing) {
        self.capability = capability;
        let job = &faulted.shard.clips[faulted.index];
        self.note_input(job);
        // Its rows are in the tables that stay: without them in the others the shard would be no shard.
        if let (Todo::Again { .. }, Some(notice)) = (self.job.todo, faulted.notices.last()) {
            let Notice { message, why, remedy, .. } = notice;
            landing.flag.halt(Halt::Fatal(format!("{message}\n  why: {why}\n  try: {remedy}")));
        }
        if faulted.notices.iter().any(|notice| notice.severity == Severity::Fault) {
            landing.gauges.faults.fetch_add(1, Ordering::Relaxed);
        }
        self.notices.insert(faulted.index, faulted.notices);
        if let Some(made) = faulted.made {
            self.made.insert(faulted.index, made);
        }
    }

    fn note_input(&mut self, job: &ClipJob) {
        match &job.origin {
            ClipOrigin::File(file) => self.record.inputs.push(InputFile {
                source: job.source.clone(),
                name: job.name.clone(),
                clip_id: job.clip_id,
                blake3: file.blake3.clone(),
                skeleton_blake3: file.skeleton_blake3.clone(),
            }),
            ClipOrigin::Kept(kept) => self.record.inputs.push(kept.input.clone()),
            ClipOrigin::Stored | ClipOrigin::Recipe(_) => {}
        }
    }

    /// The id of the clip's skeleton, whose row is added if it is the first of that body in the shard.
    fn skeleton_of(&mut self, work: &Work) -> String {
        let clip = work.clip();
        let lengths = median_bone_lengths_mm(clip, work.poses(), &work.roles);
        let id = clip.skeleton.skeleton_id(&lengths);
        let job = work.job();
        let same = |row: &&SkeletonRow| row.skeleton_id == id && row.body == *clip.skeleton;
        let first_clip = match self.record.skeletons.iter().find(same) {
            Some(row) => row.first_clip.clone(),
            None => {
                let first_clip = [job.source.clone(), job.name.clone()];
                self.record.skeletons.push(SkeletonRow {
                    skeleton_id: id.clone(),
                    first_clip: first_clip.clone(),
                    body: (*clip.skeleton).clone(),
                    roles: work.roles.clone(),
                    header: work.facts.header.clone(),
                });
                first_clip
            }
        };
        self.record.bodies.insert(job.clip_id, first_clip);
        id
    }

    fn commit(mut self) -> Result<Landed, CorpusError> {
        let job = &self.job;
        let finished = self.writer.finish()?;
        if job.todo == Todo::Everything {
            self.record.faults = fault_rows(job, &self.notices);
            self.record.made = self.made.into_values().collect();
            self.record.clips.sort_by_key(|row| row.clip_id);
            self.record.inputs.sort_by_key(|input| input.clip_id);
            sort_skeletons(&mut self.record);
        }
        self.record.keys = job.keys.clone();
        let record = finished.commit(self.record)?;
        Ok(Landed {
            clips: record.clips.len() as u32,
            frames: record.clips.iter().map(|row| u64::from(row.frames)).sum(),
            faults: record.faults.iter().filter(|row| row.notice.severity == Severity::Fault).count() as u32,
        })
    }
}

/// Sorts the skeletons, and leaves to be said only whose body is not the first of its skeleton.
fn sort_skeletons(ShardRecord { skeletons, bodies, clips, .. }: &mut ShardRecord) {
    skeletons.sort_by(|a, b| (&a.skeleton_id, &a.first_clip).cmp(&(&b.skeleton_id, &b.first_clip)));
    for clip in clips.iter() {
        let first = skeletons.iter().find(|row| row.skeleton_id == clip.skeleton);
        if first.is_some_and(|row| bodies.get(&clip.clip_id) == Some(&row.first_clip)) {
            bodies.remove(&clip.clip_id);
        }
    }
}

/// What a fatal error says to the user.
pub(super) fn fatal_text(error: &CorpusError) -> String {
    format!("{error}\n  why: {}\n  try: {}", error.why(), error.remedy())
}

fn plain_row(job: &ClipJob, work: &Work, skeleton: String) -> ClipRow {
    let clip = work.clip();
    ClipRow {
        clip_id: job.clip_id,
        name: job.name.clone(),
        source: job.source.clone(),
        format: ClipFormat::Made,
        layout: clip.skeleton.layout_id(),
        skeleton,
        subject: None,
        frames: clip.n_frames as u32,
        rate_hz: clip.rate_hz,
        frame_time_s: None,
        duration_s: clip.duration_s(),
        unit_m: clip.unit_m,
        max_rounding: 0.0,
        licenses: Vec::new(),
        attribution: None,
        may_share: None,
        may_sell: None,
        origin: Origin::Graft,
        parents: Vec::new(),
        recipe: None,
        labels: work.annotated.clip.clone(),
        warnings: 0,
        up_axis: clip.up,
    }
}

/// The terms of a made clip: all licenses of its parents, and no right that one of them withholds.
fn terms_of(mut row: ClipRow, parents: &[&ClipRow]) -> ClipRow {
    let all = |of: fn(&ClipRow) -> Option<bool>| {
        if parents.iter().any(|parent| of(parent) == Some(false)) {
            Some(false)
        } else if parents.iter().all(|parent| of(parent) == Some(true)) {
            Some(true)
        } else {
            None
        }
    };
    row.may_share = all(|parent| parent.may_share);
    row.may_sell = all(|parent| parent.may_sell);
    let mut attributions: Vec<&str> = Vec::new();
    for parent in parents {
        for license in &parent.licenses {
            if !row.licenses.contains(license) {
                row.licenses.push(license.clone());
            }
        }
        attributions.extend(parent.attribution.as_deref().filter(|text| !attributions.contains(text)));
    }
    row.attribution = (!attributions.is_empty()).then(|| attributions.join(" "));
    row.subject = parents.first().and_then(|base| base.subject.clone());
    row
}

fn fault_rows(job: &ShardJob, notices: &BTreeMap<usize, Vec<Notice>>) -> Vec<FaultRow> {
    let rows = notices.iter().flat_map(|(&index, notices)| {
        let clip = &job.clips[index];
        notices.iter().map(|notice| FaultRow {
            source: clip.source.clone(),
            name: clip.name.clone(),
            notice: notice.clone(),
        })
    });
    rows.collect()
}

fn refused(what: String) -> Notice {
    Notice {
        severity: Severity::Fault,
        kind: "tables-refused".to_owned(),
        line: None,
        frame: None,
        count: 1,
        message: format!("the tables can't hold the clip: {what}"),
        why: "a number that is not finite would spoil every mean over its column".to_owned(),
        remedy: "look at the clip's values; if they are sound, report this".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::plan::Plan;
    use std::cell::RefCell;
    use std::collections::VecDeque;
    use std::path::Path;
    use timely::dataflow::operators::generic::operator::{empty, source};
    use timely::worker::Worker;

    /// What the test's source does next.
    enum Step {
        Give(usize),
        Advance(Lane),
        /// Without this the dataflow, and so the test, would never be done.
        End,
    }

    fn fault(shard: &Arc<ShardJob>, index: usize) -> Faulted {
        let notices = vec![refused("a test".to_owned())];
        Faulted { shard: Arc::clone(shard), taken: 0, index, notices, made: None }
    }

    /// Runs the writer on faults of one shard of two clips, and tells after each step whether its record is there.
    fn write(folder: &Path, steps: Vec<Step>, flag: &Arc<HaltFlag>) -> Vec<bool> {
        let (store, flag) = (Store::new(folder), Arc::clone(flag));
        timely::execute_directly(move |worker: &mut Worker| {
            let shard = Arc::new(ShardJob::of_stored(2));
            let flight = Rc::new(Flight::default());
            flight.shards.set(1);
            flight.clips.set(2);
            let next = Rc::new(RefCell::new(VecDeque::<Step>::new()));
            let landing = Landing {
                store: store.clone(),
                settings: Arc::new(RunSettings::of(&Plan::load("annotate", None, &[]).unwrap())),
                flight,
                flag,
                gauges: Arc::new(Gauges::default()),
                parents: Arc::new(BTreeMap::new()),
            };
            let (given, of) = (Rc::clone(&next), Arc::clone(&shard));
            worker.dataflow::<Lane, _, _>(|scope| {
                let faults = source::<_, CapacityContainerBuilder<Vec<Faulted>>, _, _>(
                    scope,
                    "Faults",
                    move |mut capability, info| {
                        let me = scope.activator_for(info.address);
                        capability.downgrade(&Lane::At(0, 0));
                        let mut capability = Some(capability);
                        move |output| {
                            let Some(held) = &mut capability else { return };
                            me.activate();
                            match given.borrow_mut().pop_front() {
                                Some(Step::Give(index)) => output.session(&*held).give(fault(&of, index)),
                                Some(Step::Advance(lane)) => held.downgrade(&lane),
                                Some(Step::End) => capability = None,
                                None => {}
                            }
                        }
                    },
                );
                let clips = empty::<_, Vec<Work>>(scope);
                write_shards(clips, faults, landing);
            });
            let there = steps.into_iter().map(|step| {
                next.borrow_mut().push_back(step);
                (0..10).for_each(|_| {
                    worker.step();
                });
                read_record(&store, shard.shard).unwrap().is_some()
            });
            let there = there.collect();
            next.borrow_mut().push_back(Step::End);
            there
        })
    }

    #[test]
    fn a_shard_is_committed_when_its_time_has_passed_and_not_before() {
        let folder = tempfile::tempdir().unwrap();
        let flag = Arc::new(HaltFlag::default());
        let steps = vec![Step::Give(0), Step::Give(1), Step::Advance(Lane::At(0, 1))];
        assert_eq!(write(folder.path(), steps, &flag), [false, false, true]);
        let record = read_record(&Store::new(folder.path()), ShardJob::of_stored(2).shard).unwrap().unwrap();
        assert_eq!((record.faults.len(), record.keys.ingest.as_str()), (2, "key"));
    }

    #[test]
    fn after_a_fatal_error_nothing_is_committed() {
        let folder = tempfile::tempdir().unwrap();
        let flag = Arc::new(HaltFlag::default());
        flag.halt(Halt::Fatal("disk full".to_owned()));
        let steps = vec![Step::Give(0), Step::Give(1), Step::Advance(Lane::At(0, 1))];
        assert_eq!(write(folder.path(), steps, &flag), [false, false, false]);
        assert!(!folder.path().join("plants").exists(), "and no file is left");
    }
}
