//! The `recipes` table: what was selected to be made.

use super::{RowTable, strings, texts};
use crate::corpus::columns::{Columns, PLAIN};
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;
use crate::synthesis::Recipe;
use arrow::array::Array;

impl RowTable for Recipe {
    const NAME: &'static str = "recipes";

    fn columns(rows: &[Recipe]) -> Columns {
        Columns::new()
            .str("recipe", rows.iter().map(|row| row.recipe.as_str()))
            .str("kind", rows.iter().map(|row| row.kind.as_str()))
            .str("base", rows.iter().map(|row| row.base.as_str()))
            .str_opt("donor", rows.iter().map(|row| row.donor.as_deref()))
            .str_list("chains", rows.iter().map(|row| row.chains.as_slice()))
            .i32_opt("alternate", PLAIN, rows.iter().map(|row| row.alternate))
            .str("options", rows.iter().map(|row| row.options.as_str()))
            .u64("seed", PLAIN, rows.iter().map(|row| row.seed))
            .str("rule", rows.iter().map(|row| row.rule.as_str()))
            .str_opt("cell", rows.iter().map(|row| row.cell.as_deref()))
    }

    fn from_rows(rows: &Rows<'_>) -> Result<Vec<Recipe>, CorpusError> {
        let (recipe, kind, base) = (texts(rows, "recipe")?, texts(rows, "kind")?, texts(rows, "base")?);
        let (donor, chains) = (strings(rows, "donor")?, rows.str_lists("chains")?);
        let (alternate, options) = (rows.i32_opt("alternate")?, texts(rows, "options")?);
        let (seed, rule, cell) = (rows.u64("seed")?, texts(rows, "rule")?, strings(rows, "cell")?);
        let row = |at: usize| Recipe {
            recipe: recipe[at].clone(),
            kind: kind[at].clone(),
            base: base[at].clone(),
            donor: donor[at].clone(),
            chains: chains[at].clone(),
            alternate: alternate.is_valid(at).then(|| alternate.value(at)),
            options: options[at].clone(),
            seed: seed[at],
            rule: rule[at].clone(),
            cell: cell[at].clone(),
        };
        Ok((0..rows.len()).map(row).collect())
    }
}
