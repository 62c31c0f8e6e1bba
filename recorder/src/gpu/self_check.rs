//! temporary
use super::*;
pub struct SelfCheck { pub checks: Vec<Check>, pub ieee_division: bool, pub contracts: bool }
pub struct Check { pub name: String, pub outcome: Outcome, pub detail: String }
pub struct Outcome;
impl Outcome { pub fn name(&self) -> &'static str { "passed" } }
impl SelfCheck { pub fn run(_: &Gpu) -> Result<Self, GpuError> { Ok(Self { checks: vec![], ieee_division: true, contracts: false }) } }
