//! What enrichment makes: portraits of the clips and the judge's reference, the size of the product, the chosen recipes as
//! shards. Worker 0 only.

use super::mill::MillContext;
use super::tree::facts;
use super::work::{ClipJob, ClipOrigin, RecipeJob, ShardJob, Todo};
use crate::annotate::Gait;
use crate::corpus::{
    Catalog, ClipRow, CorpusError, FileNotes, Manifest, ShardId, ShardKind, ShardRecord, StageKeys, read_recipes,
    read_records, read_reference, remove_shard, write_made, write_recipes, write_reference,
};
use crate::motion::{Clip, RoleMap};
use crate::plan::keys::digest;
use crate::plan::{ClipFilter, PlanKeys, shard_key};
use crate::synthesis::judge::{Measure, RangeCounts, Reference, ReferenceCounts};
use crate::synthesis::portrait::Portrait;
use crate::synthesis::{Made, Movement, Recipe, product, selection};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Recipes in a shard.
const RECIPES_A_SHARD: usize = 20;
/// Source of made clips.
const SOURCE: &str = "grafts";

pub(super) const RECIPES_KEY: &str = "recipes";
const MAKE_KEY: &str = "make";
pub(super) const MADE_KEY: &str = "made";
const FIRST_CLIP: &str = "make/first_clip_id";
const FIRST_SHARD: &str = "make/first_shard";

/// Chooses recipes, or takes those that were chosen for the same clips and settings before; gives what is to be made.
pub(crate) fn plan_enrichment(
    keys: &PlanKeys,
    filter: &ClipFilter,
    no_derivatives: &BTreeSet<String>,
    manifest: &mut Manifest,
    context: &MillContext,
) -> Result<(Vec<Recipe>, Vec<ShardJob>), CorpusError> {
    let catalog = context.catalog.as_ref().ok_or_else(|| CorpusError::NotThere { what: "the catalog".to_owned() })?;
    let records: Vec<&ShardRecord> =
        catalog.records().iter().filter(|record| record.shard.kind == ShardKind::Captured).collect();
    let clip_keys: Vec<String> = records
        .iter()
        .map(|record| format!("{} {} {}", record.shard, record.keys.ingest, record.keys.labels))
        .collect();
    let recipes_key = shard_key(&keys.recipes, &clip_keys);
    // A corpus of a version that had no reference has recipes and gets one now.
    let recipes = if manifest.stages.get(RECIPES_KEY) == Some(&recipes_key) && manifest.reference.is_some() {
        read_recipes(&context.store)?
    } else {
        let (portraits, counts) = portraits(filter, catalog, context)?;
        let recipes = choose(no_derivatives, &portraits, manifest, context);
        manifest.forget([RECIPES_KEY], &context.store)?;
        freeze(&counts, manifest, context)?;
        manifest.note_files([write_recipes(&context.store, &recipes, &FileNotes::new())?]);
        manifest.stages.insert(RECIPES_KEY.to_owned(), recipes_key.clone());
        recipes
    };
    let reference = manifest.reference.clone().unwrap_or_default();
    let make_key = shard_key(&keys.judge, &[keys.make.clone(), recipes_key, reference]);
    if manifest.stages.get(MAKE_KEY) != Some(&make_key) {
        manifest.forget([MAKE_KEY], &context.store)?;
        for record in read_records(&context.store)?.iter().filter(|record| record.shard.kind == ShardKind::Made) {
            remove_shard(&context.store, record)?;
        }
        manifest.stages.insert(FIRST_CLIP.to_owned(), manifest.next_clip_id.to_string());
        manifest.stages.insert(FIRST_SHARD.to_owned(), manifest.next_made_shard.to_string());
        manifest.next_clip_id += recipes.len() as u32;
        manifest.next_made_shard += recipes.len().div_ceil(RECIPES_A_SHARD) as u32;
        manifest.stages.insert(MAKE_KEY.to_owned(), make_key.clone());
    }
    manifest.put(&context.store)?;
    let shards = shards_of(&recipes, &make_key, keys, catalog, manifest, context)?;
    Ok((recipes, shards))
}

/// Writes `made` from the records of the made shards, in the order of the recipes, unless its key says that it is there.
/// Answers whether it did.
pub(crate) fn write_made_table(
    recipes: &[Recipe],
    manifest: &mut Manifest,
    context: &MillContext,
) -> Result<bool, CorpusError> {
    let mut rows = BTreeMap::<String, Made>::new();
    for record in read_records(&context.store)?.into_iter().filter(|record| record.shard.kind == ShardKind::Made) {
        rows.extend(record.made.into_iter().map(|made| (made.recipe.clone(), made)));
    }
    let ordered: Vec<Made> = recipes.iter().filter_map(|recipe| rows.remove(&recipe.recipe)).collect();
    let key = shard_key(MADE_KEY, &[digest(&serde_json::json!(ordered))]);
    if manifest.stages.get(MADE_KEY) == Some(&key) {
        return Ok(false);
    }
    manifest.forget([MADE_KEY], &context.store)?;
    let figures: Vec<&str> = Measure::ALL.iter().map(|measure| measure.name()).collect();
    manifest.note_files([write_made(&context.store, &ordered, &figures, &FileNotes::new())?]);
    manifest.stages.insert(MADE_KEY.to_owned(), key);
    manifest.put(&context.store)?;
    Ok(true)
}

/// Enters the layouts that the reference lacks. What the first enrichment froze stays as it is, so that clips judged
/// before and after the corpus grew are judged alike.
fn freeze(counts: &ReferenceCounts, manifest: &mut Manifest, context: &MillContext) -> Result<(), CorpusError> {
    let mut reference = match manifest.reference {
        Some(_) => read_reference(&context.store)?,
        None => Reference::default(),
    };
    reference.enter(counts, context.settings.gates.min_reference_s);
    let file = write_reference(&context.store, &reference)?;
    manifest.reference = Some(file.blake3.clone());
    manifest.note_files([file]);
    Ok(())
}

fn choose(
    no_derivatives: &BTreeSet<String>,
    portraits: &[Portrait],
    manifest: &mut Manifest,
    context: &MillContext,
) -> Vec<Recipe> {
    let settings = &context.settings;
    manifest.products.clear();
    for (rule, size) in product::count(portraits, &settings.graft.correlation) {
        manifest.set_product(rule.name(), size);
    }
    let may_give: Vec<bool> = portraits
        .iter()
        .map(|portrait| portrait.name.split('/').next().is_none_or(|source| !no_derivatives.contains(source)))
        .collect();
    selection::select(portraits, &may_give, &settings.selection, &settings.graft.correlation)
}

/// Portraits of all captured clips of one of the four gaits, by (source, name), and how their joints turn.
fn portraits(
    filter: &ClipFilter,
    catalog: &Catalog,
    context: &MillContext,
) -> Result<(Vec<Portrait>, ReferenceCounts), CorpusError> {
    let settings = &context.settings;
    let (mut portraits, mut counts) = (Vec::new(), ReferenceCounts::default());
    for reader in catalog.shards().filter(|reader| reader.record().shard.kind == ShardKind::Captured) {
        let rows: BTreeMap<u32, &ClipRow> = reader
            .record()
            .clips
            .iter()
            .filter(|row| is_candidate(row, filter))
            .map(|row| (row.clip_id, row))
            .collect();
        let layouts: BTreeSet<&str> = rows.values().map(|row| row.layout.as_str()).collect();
        let mut clips: Vec<(&ClipRow, Clip, RoleMap)> = Vec::new();
        for layout in layouts {
            for clip in reader.all_channels(layout)? {
                let (clip_id, channels) = clip?;
                let Some(&row) = rows.get(&clip_id) else { continue };
                let skeleton = reader.skeleton(clip_id)?;
                let clip = Clip {
                    skeleton: Arc::new(skeleton.body.clone()),
                    rate_hz: row.rate_hz,
                    unit_m: row.unit_m,
                    up: row.up_axis,
                    n_frames: row.frames as usize,
                    channels,
                };
                clips.push((row, clip, skeleton.roles.clone()));
            }
        }
        let drawn: Vec<Option<(Portrait, RangeCounts)>> = clips
            .par_iter()
            .map(|(row, clip, roles)| {
                // A body without arms or chest has no part in grafts.
                let movement = Movement::of_clip(clip, roles).ok()?;
                let gait = row.labels.gait_class?;
                let told = (&settings.action, &settings.graft.correlation, &settings.gates);
                let (name, layout, seam_s) = (row.full_name(), row.layout.clone(), settings.graft.seam_s);
                let portrait = Portrait::of(name, layout, gait, &movement, seam_s, told);
                Some((portrait, RangeCounts::of(&movement)))
            })
            .collect();
        for (portrait, turned) in drawn.into_iter().flatten() {
            counts.add(&portrait.layout, turned);
            portraits.push(portrait);
        }
    }
    portraits.sort_by(|a, b| a.name.cmp(&b.name));
    Ok((portraits, counts))
}

fn is_candidate(row: &ClipRow, filter: &ClipFilter) -> bool {
    let graftable = matches!(row.labels.gait_class, Some(Gait::Stand | Gait::Walk | Gait::Run | Gait::Jump));
    graftable && filter.lets_through(&facts(row))
}

/// The made shards that are not done. Numbers follow the order of choice, shards hold recipes of one base side by side.
fn shards_of(
    recipes: &[Recipe],
    make_key: &str,
    keys: &PlanKeys,
    catalog: &Catalog,
    manifest: &Manifest,
    context: &MillContext,
) -> Result<Vec<ShardJob>, CorpusError> {
    let number = |name: &str| manifest.stages.get(name).and_then(|text| text.parse::<u32>().ok()).unwrap_or(0);
    let (first_clip, first_shard) = (number(FIRST_CLIP), number(FIRST_SHARD));
    let ids: BTreeMap<String, u32> = catalog.clips().map(|row| (row.full_name(), row.clip_id)).collect();
    let mut order: Vec<usize> = (0..recipes.len()).collect();
    order.sort_by(|&a, &b| (&recipes[a].base, &recipes[a].donor, a).cmp(&(&recipes[b].base, &recipes[b].donor, b)));
    let names = names_of(recipes);
    let done: BTreeMap<ShardId, StageKeys> = read_records(&context.store)?
        .into_iter()
        .map(|mut record| {
            record.forget_lost(&context.store);
            (record.shard, record.keys)
        })
        .collect();
    let mut shards = Vec::new();
    for (place, chunk) in order.chunks(RECIPES_A_SHARD).enumerate() {
        let shard = ShardId::made(first_shard + place as u32);
        let mut clips: Vec<ClipJob> = chunk
            .iter()
            .filter_map(|&at| {
                let recipe = &recipes[at];
                let parent = |name: &str| ids.get(name).copied();
                Some(ClipJob {
                    clip_id: first_clip + at as u32,
                    source: SOURCE.to_owned(),
                    name: names[at].clone(),
                    origin: ClipOrigin::Recipe(Box::new(RecipeJob {
                        recipe: recipe.clone(),
                        base: parent(&recipe.base)?,
                        donor: parent(recipe.donor.as_deref()?)?,
                    })),
                })
            })
            .collect();
        clips.sort_by_key(|clip| clip.clip_id);
        let clip_keys: Vec<String> = clips.iter().map(|clip| format!("{}:{}", clip.clip_id, clip.name)).collect();
        let wanted = StageKeys {
            ingest: shard_key(make_key, &clip_keys),
            features: shard_key(&keys.features, &clip_keys),
            labels: shard_key(&keys.labels, &clip_keys),
        };
        if done.get(&shard) != Some(&wanted) {
            shards.push(ShardJob { shard, replaces: Vec::new(), todo: Todo::Everything, keys: wanted, clips });
        }
    }
    Ok(shards)
}

/// Names of made clips: both parents' last components and the end of the recipe's name, which tells alike ones apart.
fn names_of(recipes: &[Recipe]) -> Vec<String> {
    let last = |name: &str| name.rsplit('/').next().unwrap_or(name).to_owned();
    recipes
        .iter()
        .map(|recipe| {
            let donor = recipe.donor.as_deref().map(last).unwrap_or_default();
            let digits = recipe.recipe.rsplit('-').next().unwrap_or_default();
            format!("{}+{donor}-{}", last(&recipe.base), &digits[..digits.len().min(6)])
        })
        .collect()
}
