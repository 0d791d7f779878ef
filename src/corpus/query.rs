//! Looking clips up by the names that people use.
//!
//! In this order: the whole name (`source/name`, then `name`), its last component, a unique prefix. The first of
//! these that fits anything decides; if it fits several clips, that is said, and none is picked.

use super::tables::ClipRow;

/// Names that a miss suggests, and clips that an ambiguity lists.
const SUGGESTIONS: usize = 5;

/// Why a look-up gave no clip.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LookUpError {
    /// No clip is called that.
    #[error("no clip is called `{name}`{}", suggestion(nearest))]
    NotFound {
        /// What was asked for.
        name: String,
        /// The most alike full names, best first.
        nearest: Vec<String>,
    },
    /// Several are.
    #[error("`{name}` fits {count} clips: {}", list(matches, *count))]
    Ambiguous {
        /// What was asked for.
        name: String,
        /// The first of them, full names, sorted.
        matches: Vec<String>,
        /// How many there are.
        count: usize,
    },
}

/// The clip of a name. Names are compared as they are written, with regard to case.
///
/// # Errors
/// [`LookUpError`].
pub fn look_up<'a>(clips: &'a [ClipRow], name: &str) -> Result<&'a ClipRow, LookUpError> {
    let whole = |clip: &ClipRow| {
        let full = clip.source.len() + 1 + clip.name.len() == name.len();
        full && name.strip_prefix(clip.source.as_str()).and_then(|rest| rest.strip_prefix('/')) == Some(&clip.name)
    };
    let rules: [&dyn Fn(&ClipRow) -> bool; 4] =
        [&whole, &|clip| clip.name == name, &|clip| last_component(&clip.name) == name, &|clip| {
            clip.name.starts_with(name)
                || last_component(&clip.name).starts_with(name)
                || (name.starts_with(clip.source.as_str()) && clip.full_name().starts_with(name))
        }];
    if !name.is_empty() {
        for rule in rules {
            let fits: Vec<&ClipRow> = clips.iter().filter(|clip| rule(clip)).collect();
            match fits[..] {
                [] => {}
                [clip] => return Ok(clip),
                _ => {
                    let mut matches: Vec<String> = fits.iter().map(|clip| clip.full_name()).collect();
                    matches.sort();
                    matches.truncate(SUGGESTIONS);
                    return Err(LookUpError::Ambiguous { name: name.to_owned(), matches, count: fits.len() });
                }
            }
        }
    }
    Err(LookUpError::NotFound { name: name.to_owned(), nearest: nearest(clips, name) })
}

fn nearest(clips: &[ClipRow], name: &str) -> Vec<String> {
    let alike = |clip: &ClipRow| {
        strsim::jaro_winkler(last_component(&clip.name), name).max(strsim::jaro_winkler(&clip.name, name))
    };
    let mut scored: Vec<(f64, String)> =
        clips.iter().map(|clip| (alike(clip), clip.full_name())).filter(|(score, _)| *score > 0.7).collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    scored.into_iter().take(SUGGESTIONS).map(|(_, name)| name).collect()
}

fn last_component(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

fn suggestion(nearest: &[String]) -> String {
    nearest.first().map_or(String::new(), |name| format!("; the nearest is `{name}`"))
}

fn list(matches: &[String], count: usize) -> String {
    let more = if count > matches.len() { " ..." } else { "" };
    format!("{}{more}", matches.join(", "))
}
