//! All adapters of this machine with what the self-check finds, for `recorder adapters`.

use std::fmt;

use serde::Serialize;

use super::self_check::{FAILED, SelfCheck};
use crate::device::adapter::enumerate;
use crate::device::{AdapterDescription, Gpu};

/// An adapter and whether it can be used.
#[derive(Clone, Debug, Serialize)]
pub struct AdapterReport {
    /// What it is.
    pub adapter: AdapterDescription,
    /// What it does; `None` where it could not be opened.
    pub self_check: Option<SelfCheck>,
    /// Why it could not be opened.
    pub error: Option<String>,
}

/// Opens and checks every adapter, the best first.
pub fn reports() -> Vec<AdapterReport> {
    let report = |adapter: &wgpu::Adapter| {
        let gpu = Gpu::open_adapter(adapter, wgpu::Features::empty());
        let checked = gpu.and_then(|gpu| SelfCheck::look(&gpu));
        let error = checked.as_ref().err().map(ToString::to_string);
        AdapterReport { adapter: AdapterDescription::of(adapter), self_check: checked.ok(), error }
    };
    enumerate().iter().map(report).collect()
}

impl AdapterReport {
    /// Whether recordings can be made on it.
    pub fn is_usable(&self) -> bool {
        let passed = |found: &SelfCheck| found.checks.iter().all(|check| check.outcome != FAILED);
        self.self_check.as_ref().is_some_and(passed)
    }
}

impl fmt::Display for AdapterReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let adapter = &self.adapter;
        let verdict = match (self.is_usable(), adapter.is_software()) {
            (false, _) => "cannot be used",
            (true, true) => "usable when named (software)",
            (true, false) => "usable",
        };
        writeln!(f, "{}: {verdict}", adapter.title())?;
        let limits = &adapter.limits;
        writeln!(
            f,
            "  {}; timestamps {}, ray query {}; storage binding up to {} MiB, buffer up to {} MiB, subgroups of {} to {}",
            adapter.device_type,
            yes(adapter.timestamps),
            yes(adapter.ray_query),
            limits.storage_binding_bytes >> 20,
            limits.buffer_bytes >> 20,
            adapter.subgroup_min_size,
            adapter.subgroup_max_size
        )?;
        if let Some(error) = &self.error {
            writeln!(f, "  {error}")?;
        }
        for check in self.self_check.iter().flat_map(|found| &found.checks) {
            writeln!(f, "  {:8} {:28} {}", check.outcome, check.name, check.detail)?;
        }
        Ok(())
    }
}

fn yes(is_offered: bool) -> &'static str {
    if is_offered { "yes" } else { "no" }
}
