//! Many runs with inputs that vary as they do in life: tolerances, and what they do to a result.
//!
//! `Study → Draws (shares of each parameter) → run (a script's function) → draws.csv → summary,
//! sensitivities, page`. The table grows by a line a draw, so that a study which is killed goes on
//! where it was.

mod design;
mod distribution;
mod merge;
mod page;
mod run;
mod sensitivity;
mod summary;
mod table;

pub use design::{Design, Draws, MOST_DRAWS, MOST_PARAMETERS};
pub use distribution::{Distribution, normal_quantile};
pub use merge::{is_study, merge, verify};
pub use run::{DRAWS, Parameter, RECORD, Study, StudyOutcome};
pub use sensitivity::{Sensitivity, sensitivity};
pub use summary::{Interval, mean, percentile_interval, probability, standard_deviation};
pub use table::DrawTable;
