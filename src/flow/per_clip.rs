//! One stage of the pipeline as an operator: a pure call a clip, faults on a stream of their own.

use super::gauges::{Gauges, Station};
use super::guard::guarded;
use super::lane::Lane;
use super::work::{Faulted, Out, Work};
use crate::motion::{Notice, Severity};
use std::sync::Arc;
use std::time::Instant;
use timely::container::CapacityContainerBuilder;
use timely::dataflow::Stream;
use timely::dataflow::channels::pact::Pipeline;
use timely::dataflow::operators::core::OkErr;
use timely::dataflow::operators::generic::operator::Operator;

/// Clips that go on, and clips that do not.
pub(crate) type Split<'scope> = (Stream<'scope, Lane, Vec<Work>>, Stream<'scope, Lane, Vec<Faulted>>);

/// Applies `stage` to every clip. A fault, or a panic inside the call, takes the clip out.
#[expect(clippy::result_large_err, reason = "the other variant, a clip on its way, is larger")]
pub(crate) fn per_clip<'scope>(
    clips: Stream<'scope, Lane, Vec<Work>>,
    station: Station,
    gauges: Arc<Gauges>,
    mut stage: impl FnMut(&mut Work) -> Result<(), Out> + 'static,
) -> Split<'scope> {
    clips
        .unary::<CapacityContainerBuilder<Vec<Result<Work, Faulted>>>, _, _, _>(
            Pipeline,
            station.name(),
            move |_, _| {
                move |input, output| {
                    input.for_each_stamp(|capability, clips| {
                        let mut session = output.session(&capability);
                        for mut work in clips.flat_map(|batch| batch.drain(..)) {
                            let start = Instant::now();
                            let done = guarded(|| stage(&mut work));
                            gauges.spent(station, start.elapsed());
                            session.give(match done {
                                Ok(Ok(())) => Ok(work),
                                Ok(Err(out)) => Err(work.out(out)),
                                Err(panic) => Err(work.out(Out::Fault(bug(station, &panic)))),
                            });
                        }
                    });
                }
            },
        )
        .ok_err(|result| result)
}

fn bug(station: Station, panic: &str) -> Notice {
    Notice {
        severity: Severity::Fault,
        kind: "internal-error".to_owned(),
        line: None,
        frame: None,
        count: 1,
        message: format!("motionmill failed on this clip in stage {}: {panic}", station.name()),
        why: "this is a bug in motionmill; the clip is left out and the run went on".to_owned(),
        remedy: "report it with the file".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::source_of_works;
    use super::*;
    use std::cell::RefCell;
    use std::rc::Rc;

    #[test]
    fn a_panic_in_the_work_on_a_clip_takes_out_that_clip_alone() {
        let (passed, faulted) = timely::execute_directly(|worker| {
            let (passed, faulted) = (Rc::new(RefCell::new(Vec::new())), Rc::new(RefCell::new(Vec::new())));
            let (good, bad) = (Rc::clone(&passed), Rc::clone(&faulted));
            worker.dataflow::<Lane, _, _>(|scope| {
                let gauges = Arc::new(Gauges::default());
                let (clips, faults) = per_clip(source_of_works(scope, 4), Station::Features, gauges, |work| {
                    assert_ne!(work.index, 2, "a bug of ours");
                    Ok(())
                });
                clips.sink(Pipeline, "Good", move |(input, _)| {
                    input.for_each_stamp(|_, batch| {
                        good.borrow_mut().extend(batch.flat_map(|batch| batch.drain(..)).map(|work| work.index));
                    });
                });
                faults.sink(Pipeline, "Bad", move |(input, _)| {
                    input.for_each_stamp(|_, batch| bad.borrow_mut().extend(batch.flat_map(|batch| batch.drain(..))));
                });
            });
            while worker.step() {}
            (passed.take(), faulted.take())
        });
        assert_eq!(passed, [0, 1, 3]);
        assert_eq!(faulted.iter().map(|faulted| faulted.index).collect::<Vec<_>>(), [2]);
        let notice = &faulted[0].notices[0];
        assert_eq!((notice.severity, notice.kind.as_str()), (Severity::Fault, "internal-error"));
        assert!(notice.message.contains("stage features") && notice.message.contains("a bug of ours"), "{notice:?}");
    }
}
