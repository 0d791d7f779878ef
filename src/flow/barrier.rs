//! A point that every worker, in every process, must have reached before any goes on.

use timely::dataflow::operators::Probe;
use timely::dataflow::operators::probe::Handle;
use timely::dataflow::operators::vec::Input;
use timely::worker::Worker;

/// Waits until all workers are here.
pub(crate) fn barrier(worker: &mut Worker) {
    let probe = Handle::<u64>::new();
    let input = worker.dataflow::<u64, _, _>(|scope| {
        let (input, stream) = scope.new_input::<()>();
        stream.probe_with(&probe);
        input
    });
    input.close();
    while !probe.done() {
        worker.step_or_park(None);
    }
}
