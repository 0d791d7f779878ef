//! Segments of one gait, and which are too short to stand alone (CONTACTS 3.7).

use super::labels::Gait;
use core::ops::Range;

/// A segment shorter than this may join its neighbors, seconds.
const SHORT_S: f64 = 0.4;

/// Longest runs of one gait.
pub fn gait_runs(gaits: &[Gait]) -> Vec<(Gait, Range<usize>)> {
    let mut runs: Vec<(Gait, Range<usize>)> = Vec::new();
    for (frame, &gait) in gaits.iter().enumerate() {
        match runs.last_mut() {
            Some((last, range)) if *last == gait => range.end = frame + 1,
            _ => runs.push((gait, frame..frame + 1)),
        }
    }
    runs
}

/// Lets short segments join their neighbors (3.7): one between equals takes their gait; a stand beside a jump becomes
/// jump; the first or the last joins a walk or run beside it. A jump is never absorbed. The first such segment goes
/// first, until none is left.
pub fn absorb_short(mut gaits: Vec<Gait>, rate_hz: f64) -> Vec<Gait> {
    // None of the segments to the left can join; those to the right (the next one last) have not been asked.
    let mut left: Vec<(Gait, Range<usize>)> = Vec::new();
    let mut right: Vec<(Gait, Range<usize>)> = gait_runs(&gaits);
    right.reverse();
    while let Some((gait, mut range)) = right.pop() {
        let (before, after) = (left.last().map(|near| near.0), right.last().map(|near| near.0));
        let short = (range.len() as f64) / rate_hz < SHORT_S;
        match joined(gait, before, after).filter(|_| short) {
            None => left.push((gait, range)),
            Some(new) => {
                gaits[range.clone()].fill(new);
                if before == Some(new)
                    && let Some((_, before)) = left.pop()
                {
                    range.start = before.start;
                }
                if after == Some(new)
                    && let Some((_, after)) = right.pop()
                {
                    range.end = after.end;
                }
                right.push((new, range));
                // The segment before has a new neighbor, so it is asked again.
                right.extend(left.pop());
            }
        }
    }
    gaits
}

/// The gait that a short segment takes over from the ones beside it, if it does.
fn joined(gait: Gait, before: Option<Gait>, after: Option<Gait>) -> Option<Gait> {
    if gait == Gait::Jump {
        return None;
    }
    match (before, after) {
        (Some(before), Some(after)) if before == after => Some(before),
        _ if gait == Gait::Stand && (before == Some(Gait::Jump) || after == Some(Gait::Jump)) => Some(Gait::Jump),
        (Some(near), None) | (None, Some(near)) if matches!(near, Gait::Walk | Gait::Run) => Some(near),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;

    /// Gaits of a text such as `w5 j2`: letters with frames.
    fn spelled(text: &str) -> Vec<Gait> {
        text.split_whitespace()
            .flat_map(|word| {
                let all = [Gait::Unknown, Gait::Stand, Gait::Walk, Gait::Run, Gait::Jump];
                let gait = all.into_iter().find(|gait| gait.name()[..1] == word[..1]).unwrap();
                vec![gait; word[1..].parse().unwrap()]
            })
            .collect()
    }

    #[test]
    fn short_segments_join() {
        for (before, after) in [
            ("", ""),
            ("w3", "w3"),
            ("w9 s3 w9", "w21"),
            ("w9 s4 w9", "w9 s4 w9"),
            ("w9 j3 w9", "w9 j3 w9"),
            ("s9 w3 j9", "s9 w3 j9"),
            ("w9 s3 j9", "w9 j12"),
            ("u3 w9", "w12"),
            ("u3 s9", "u3 s9"),
            ("w9 u3", "w12"),
            ("j9 s3", "j12"),
            ("r3 w3", "w6"),
            // The run has jumps on both sides once the stand has become one.
            ("j9 r3 s3 j9", "j24"),
            ("j9 w2 r3 s3 j9", "j9 w2 r3 j12"),
            ("w3 s3 w3 s3 w3", "w15"),
        ] {
            assert_eq!(absorb_short(spelled(before), 10.0), spelled(after), "{before}");
        }
    }

    /// The definition, word for word.
    fn plain(mut gaits: Vec<Gait>, rate_hz: f64) -> Vec<Gait> {
        'again: loop {
            let runs = gait_runs(&gaits);
            for (at, (gait, range)) in runs.iter().enumerate() {
                let near = |at: Option<usize>| at.and_then(|at| runs.get(at)).map(|run| run.0);
                if let Some(new) = joined(*gait, near(at.checked_sub(1)), near(Some(at + 1)))
                    && range.len() as f64 / rate_hz < SHORT_S
                {
                    gaits[range.clone()].fill(new);
                    continue 'again;
                }
            }
            return gaits;
        }
    }

    proptest::proptest! {
        #[test]
        fn one_pass_does_what_starting_over_does(
            runs in proptest::collection::vec((0_usize..5, 1_usize..7), 0..12),
        ) {
            let all = [Gait::Unknown, Gait::Stand, Gait::Walk, Gait::Run, Gait::Jump];
            let gaits: Vec<Gait> = runs.iter().flat_map(|&(gait, n)| vec![all[gait]; n]).collect();
            proptest::prop_assert_eq!(absorb_short(gaits.clone(), 10.0), plain(gaits, 10.0));
        }
    }
}
