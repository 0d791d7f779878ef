//! Recipes and what became of them; the judged figures of a made clip beside its parents'.

use super::numbers::{counted, grouped};
use super::table::{Side, Table};
use crate::corpus::ClipRow;
use crate::synthesis::judge::Measure;
use crate::synthesis::{Figure, Made, Recipe};
use serde_json::{Value, json};
use std::collections::BTreeMap;

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// Verdicts: how many of each, then recipe by recipe, accepted ones first.
pub(super) fn text(recipes: &[Recipe], made: &[Made], clips: &[ClipRow]) -> String {
    let verdicts: BTreeMap<&str, &Made> = made.iter().map(|made| (made.recipe.as_str(), made)).collect();
    let names: BTreeMap<u32, String> = clips.iter().map(|clip| (clip.clip_id, clip.full_name())).collect();
    let accepted = made.iter().filter(|made| made.accepted).count() as u64;
    let mut reasons = BTreeMap::<&str, u64>::new();
    made.iter().flat_map(|made| &made.reasons).for_each(|reason| *reasons.entry(reason).or_default() += 1);
    let mut reasons: Vec<(&str, u64)> = reasons.into_iter().collect();
    reasons.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
    let reasons: Vec<String> = reasons.iter().map(|(reason, count)| format!("{reason} {count}")).collect();
    let because = if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join(", ")) };
    let mut table = Table::new(&[
        ("verdict", Side::Left),
        ("clip or recipe", Side::Left),
        ("rule", Side::Left),
        ("chains", Side::Left),
        ("base", Side::Left),
        ("donor", Side::Left),
        ("reasons", Side::Left),
    ]);
    let mut ordered: Vec<(&Recipe, Option<&Made>)> =
        recipes.iter().map(|recipe| (recipe, verdicts.get(recipe.recipe.as_str()).copied())).collect();
    ordered.sort_by_key(|(_, made)| made.map_or(2, |made| u8::from(!made.accepted)));
    for (recipe, made) in ordered {
        let clip = made.and_then(|made| made.clip_id).and_then(|id| names.get(&id));
        table.row([
            made.map_or("not made", |made| if made.accepted { "accepted" } else { "rejected" }).to_owned(),
            clip.unwrap_or(&recipe.recipe).clone(),
            recipe.rule.clone(),
            recipe.chains.join("+"),
            recipe.base.clone(),
            recipe.donor.clone().unwrap_or_default(),
            made.map_or(String::new(), |made| made.reasons.join(", ")),
        ]);
    }
    let rejected = grouped(made.len() as u64 - accepted);
    let counts = format!(
        "{}: {} accepted, {rejected} rejected{because}",
        counted(recipes.len() as u64, "recipe"),
        grouped(accepted)
    );
    format!("{counts}\n{}", table.text())
}

/// The same for programs.
pub(super) fn json(recipes: &[Recipe], made: &[Made], clips: &[ClipRow]) -> Value {
    let verdicts: BTreeMap<&str, &Made> = made.iter().map(|made| (made.recipe.as_str(), made)).collect();
    let names: BTreeMap<u32, String> = clips.iter().map(|clip| (clip.clip_id, clip.full_name())).collect();
    recipes
        .iter()
        .map(|recipe| {
            let made = verdicts.get(recipe.recipe.as_str()).copied();
            json!({
                "recipe": recipe,
                "clip": made.and_then(|made| made.clip_id).and_then(|id| names.get(&id)),
                "made": made.map(|made| json!({
                    "clip_id": made.clip_id, "accepted": made.accepted, "reasons": made.reasons,
                    "base_range": made.base_range, "donor_range": made.donor_range,
                    "figures": figures_json(&made.figures),
                })),
            })
        })
        .collect()
}

/// Judged figures beside the parents', those that were computed; angles in degrees.
pub(super) fn figures(figures: &[Figure]) -> String {
    let mut table = Table::new(&[
        ("judged", Side::Left),
        ("own", Side::Right),
        ("base", Side::Right),
        ("donor", Side::Right),
        ("", Side::Left),
    ]);
    for figure in figures {
        let (factor, unit) = Measure::from_name(&figure.name).map_or((1.0, ""), shown);
        let number = |value: Option<f32>| value.map_or("-".to_owned(), |value| significant(f64::from(value) * factor));
        if [figure.own, figure.base, figure.donor].iter().any(Option::is_some) {
            let name = figure.name.replace('_', " ");
            table.row([name, number(figure.own), number(figure.base), number(figure.donor), unit.to_owned()]);
        }
    }
    if table.is_empty() { String::new() } else { table.text() }
}

/// Figures as an object: `{"skate": {"own": ..., "base": ..., "donor": ...}}`, in the units of the table `made`.
pub(super) fn figures_json(figures: &[Figure]) -> Value {
    let figure = |figure: &Figure| {
        // By way of text: an f32 as its shortest decimal.
        let text = serde_json::to_string(&[figure.own, figure.base, figure.donor]).unwrap_or_default();
        let values: [Value; 3] = serde_json::from_str(&text).unwrap_or_default();
        let [own, base, donor] = values;
        (figure.name.clone(), json!({"own": own, "base": base, "donor": donor}))
    };
    Value::Object(figures.iter().map(figure).collect())
}

/// What a figure is multiplied by to be shown, and the unit then.
fn shown(measure: Measure) -> (f64, &'static str) {
    match measure {
        Measure::WristJerk => (1.0, "m/s³"),
        Measure::UpperAngularAcceleration | Measure::LegAngularAcceleration => (DEGREES, "°/s²"),
        Measure::Skate => (1.0, "m/s"),
        Measure::PlantDrift | Measure::Penetration | Measure::SelfCollision | Measure::ZmpDistance => (1.0, "m"),
        Measure::LimitExcess => (DEGREES, "°"),
        Measure::ArmLegRelation => (1.0, "cycles"),
        Measure::ArmNovelty | Measure::ArmLegLock | Measure::PoseNovelty => (1.0, ""),
    }
}

/// Three digits that count, or all that stand before the point.
fn significant(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        size if size >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.4}"),
    }
}
