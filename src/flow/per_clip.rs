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
