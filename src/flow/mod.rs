//! The plan as timely dataflows: operators, exchange, commits, faults, several processes. The only room that names
//! timely or differential-dataflow.
//!
//! ```text
//! prepare -> [clips: mill] -> fold -> [cluster: tree, graph] -> [enrich: mill] -> fold        (run.rs)
//! ```
//!
//! - The shard is the unit of work, commit and resume; shards are cut before any work, and who mills which changes
//!   nothing (`tickets`, `shard_source`, `lane`).
//! - Arithmetic lives in the pure rooms; operators hold state and time (`per_clip`, `clip_stages`, `make_stages`).
//! - Nothing is written but by `shard_writer`, the two table writers of the cluster dataflow, and worker 0's folds.
//! - Between dataflows all workers meet, and go on or leave together (`agree`): one that left alone would hang the rest.
//! - Nothing prints: `gauges` are read, `halt` and `guard` say how a run ends.

mod agree;
mod clip_stages;
pub mod compact;
mod enrich;
pub mod gauges;
mod graph;
mod graph_collections;
pub mod guard;
pub mod halt;
mod jobs;
mod lane;
mod make_stages;
mod memory;
pub mod mesh;
mod mill;
mod per_clip;
mod prepare;
pub mod run;
pub mod settings;
mod shard_source;
mod shard_writer;
mod tickets;
mod tree;
mod work;

pub use compact::compact;
pub use run::{Dataflow, RunError, RunReport, RunRequest, noted_plan, run};

/// Clips without text of one shard, for tests of operators: at the first time of worker 0, and nothing after.
#[cfg(test)]
fn source_of_works(
    scope: timely::dataflow::Scope<'_, lane::Lane>,
    n_clips: usize,
) -> timely::dataflow::Stream<'_, lane::Lane, Vec<work::Work>> {
    use timely::container::CapacityContainerBuilder;
    use timely::dataflow::operators::generic::operator::source;
    let shard = std::sync::Arc::new(work::ShardJob::of_stored(n_clips as u32));
    source::<_, CapacityContainerBuilder<Vec<work::Work>>, _, _>(scope, "Works", move |mut capability, _| {
        capability.downgrade(&lane::Lane::At(0, 0));
        let mut capability = Some(capability);
        move |output| {
            if let Some(capability) = capability.take() {
                let mut session = output.session(&capability);
                (0..n_clips).for_each(|index| session.give(work::Work::new(std::sync::Arc::clone(&shard), 0, index)));
            }
        }
    })
}
