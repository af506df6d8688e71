//! Figure 7: clones trained with many objects, searching for few.

use super::curves;
use super::markup::Markup;
use super::part::Part;
use super::section::Section;
use super::study::Comparison;
use super::table_2;
use crate::ExperimentError;

pub(super) fn section(comparison: &Comparison) -> Result<Section, ExperimentError> {
    let caption = "F1 against path length, mean and standard error (shaded), 1 % of the cells hold an object. All clones \
                   were trained with objects in 20 % of them.";
    let drawn = curves::figure(comparison, Part::Figure7, caption)?;
    let body = Markup::new()
        .paragraph(
            "The paper: clones that were trained with objects in 20 % of the cells closely track their expert with objects \
             in 1 %, on all four maps. Its Table II has the areas under these curves.",
        )
        .then(&drawn.figure)
        .table(&curves::table(comparison));
    Ok(Section {
        part: Part::Figure7,
        title: "Fewer objects than in training",
        body,
        claims: vec![table_2::tracking(comparison)],
        files: curves::files(comparison, Part::Figure7, drawn.files)?,
    })
}
