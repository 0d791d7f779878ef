//! Cutting the sorted list of inputs into shards, before any work and without regard to who will do it (DESIGN 3, 4).

use std::ops::Range;

/// A unit of work, commit and resume: a run of the sorted list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Indices into the list that was cut.
    pub clips: Range<usize>,
    /// Text of these clips, bytes.
    pub bytes: u64,
}

/// Cuts the list so that a shard has at most `text_bytes` of text, or one clip.
///
/// The list is sorted by (source, name), as [`find_inputs`](super::find_inputs) gives it, or a part of that in its order.
pub fn cut_shards(sizes: impl IntoIterator<Item = u64>, text_bytes: u64) -> Vec<Shard> {
    let mut shards: Vec<Shard> = Vec::new();
    for (index, bytes) in sizes.into_iter().enumerate() {
        match shards.last_mut() {
            Some(shard) if shard.bytes.saturating_add(bytes) <= text_bytes => {
                shard.clips.end = index + 1;
                shard.bytes += bytes;
            }
            _ => shards.push(Shard { clips: index..index + 1, bytes }),
        }
    }
    shards
}
