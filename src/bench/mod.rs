//! Floor 9: time against error of every method, what `auto` chooses, how cost grows, and the budgets.
//!
//! A family ([`families`]) is a question with one reference answer; a method is one way to answer it at rising effort. Adding
//! a method is one entry in the file of its family, adding a family one line in [`families::all`]; runner, files and charts
//! take it from there.

pub mod budgets;
pub mod choice;
pub mod equal_time;
pub mod evidence;
pub mod families;
pub mod machine;
pub mod method;
pub mod patches;
pub mod runner;
pub mod scaling;
pub mod stopwatch;
pub mod surface;

pub use equal_time::{EqualTime, equal_time};
pub use evidence::{accuracy_chart, counts_chart, rungs_csv};
pub use machine::Machine;
pub use method::{Answer, Distance, Family, Method, Reference};
pub use runner::{Plan, Rung, run};
