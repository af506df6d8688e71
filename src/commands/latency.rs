//! What decisions share is built before any of them is measured.

use dragnet_search::information::InformationTable;

/// Builds what all decisions share, so that the first one is not measured with it.
pub(super) fn warm_up() {
    let _ = InformationTable::shared();
}
