//! The `made` table: what became of each recipe, and its judged figures beside its parents'.

use super::texts;
use crate::corpus::columns::{Columns, PLAIN};
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;
use crate::synthesis::{Figure, Made};
use arrow::array::{Array, Float32Array, UInt32Array};

/// Columns before the figures.
const FIXED: usize = 8;

/// Columns of rows that all have the figures of these names, in this order, or none at all (never judged).
///
/// Returns the name of the first recipe whose figures are others.
pub(in crate::corpus) fn made_columns(rows: &[Made], figures: &[&str]) -> Result<Columns, String> {
    let fits = |row: &Made| {
        row.figures.is_empty() || row.figures.iter().map(|figure| &*figure.name).eq(figures.iter().copied())
    };
    if let Some(row) = rows.iter().find(|row| !fits(row)) {
        return Err(row.recipe.clone());
    }
    let bound =
        |range: fn(&Made) -> Option<[u32; 2]>, n: usize| rows.iter().map(move |row| range(row).map(|range| range[n]));
    let mut columns = Columns::new()
        .str("recipe", rows.iter().map(|row| row.recipe.as_str()))
        .u32_opt("clip_id", PLAIN, rows.iter().map(|row| row.clip_id))
        .bool("accepted", rows.iter().map(|row| row.accepted))
        .str_list("reasons", rows.iter().map(|row| row.reasons.as_slice()))
        .u32_opt("base_first", PLAIN, bound(|row| row.base_range, 0))
        .u32_opt("base_end", PLAIN, bound(|row| row.base_range, 1))
        .u32_opt("donor_first", PLAIN, bound(|row| row.donor_range, 0))
        .u32_opt("donor_end", PLAIN, bound(|row| row.donor_range, 1));
    for (at, name) in figures.iter().enumerate() {
        let value = |of: fn(&Figure) -> Option<f32>| rows.iter().map(move |row| row.figures.get(at).and_then(of));
        columns = columns
            .f32_opt(name, PLAIN, value(|figure| figure.own))
            .f32_opt(&format!("{name}_base"), PLAIN, value(|figure| figure.base))
            .f32_opt(&format!("{name}_donor"), PLAIN, value(|figure| figure.donor));
    }
    Ok(columns)
}

/// The rows of a batch; the figures are those that the file has. A row whose figures are all null was never judged
/// and comes back without them.
pub(in crate::corpus) fn made_from_rows(rows: &Rows<'_>) -> Result<Vec<Made>, CorpusError> {
    let (recipe, clip_id) = (texts(rows, "recipe")?, rows.u32_opt("clip_id")?);
    let (accepted, reasons) = (rows.bool("accepted")?, rows.str_lists("reasons")?);
    let base = [rows.u32_opt("base_first")?, rows.u32_opt("base_end")?];
    let donor = [rows.u32_opt("donor_first")?, rows.u32_opt("donor_end")?];
    let names = rows.names();
    let mut figures = Vec::new();
    for name in names.iter().skip(FIXED).step_by(3) {
        let columns =
            [rows.f32_opt(name)?, rows.f32_opt(&format!("{name}_base"))?, rows.f32_opt(&format!("{name}_donor"))?];
        figures.push(((*name).to_owned(), columns));
    }
    let number = |column: &UInt32Array, at: usize| column.is_valid(at).then(|| column.value(at));
    let range =
        |bounds: [&UInt32Array; 2], at: usize| number(bounds[0], at).zip(number(bounds[1], at)).map(<[u32; 2]>::from);
    let float = |column: &Float32Array, at: usize| column.is_valid(at).then(|| column.value(at));
    let row = |at: usize| {
        let own = figures.iter().map(|(name, [own, base, donor])| Figure {
            name: name.clone(),
            own: float(own, at),
            base: float(base, at),
            donor: float(donor, at),
        });
        let own: Vec<Figure> = own.collect();
        let judged = own.iter().any(|figure| figure.own.or(figure.base).or(figure.donor).is_some());
        Made {
            recipe: recipe[at].clone(),
            clip_id: number(clip_id, at),
            accepted: accepted.value(at),
            reasons: reasons[at].clone(),
            base_range: range(base, at),
            donor_range: range(donor, at),
            figures: if judged { own } else { Vec::new() },
        }
    };
    Ok((0..rows.len()).map(row).collect())
}
