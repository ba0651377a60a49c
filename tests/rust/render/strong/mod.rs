//! Maps whose w varies by many orders of magnitude: the cases, and the oracle that judges them.

pub mod cases;
pub mod oracle;
