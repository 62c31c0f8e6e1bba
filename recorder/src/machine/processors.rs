//! The processors that threads run on: which there are, how memory reaches them, and threads tied to them.

use anyhow::Result;

/// A processor by its name and, where the system tells them, family and model: in a virtual machine all of a maker's
/// often have one name.
pub(super) fn name(brand: &str) -> String {
    let facts = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    match family_and_model(&facts) {
        Some(which) => format!("{brand}, {which}"),
        None => brand.to_owned(),
    }
}

/// Of the first processor that Linux on x86 tells of.
fn family_and_model(facts: &str) -> Option<String> {
    let value = |name: &str| {
        let fields = facts.lines().filter_map(|line| line.split_once(':'));
        fields.map(|(key, value)| (key.trim(), value.trim())).find(|(key, _)| *key == name)
    };
    Some(format!("family {}, model {}", value("cpu family")?.1, value("model")?.1))
}

/// What of the machine times depend on beside its processor, by name; nothing where the system does not tell.
///
/// `smt`: 1 where a core runs several threads. `huge_pages`: 0 never, 1 where a program asks, 2 always.
pub(super) fn facts() -> Vec<(String, u64)> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let smt = read("/sys/devices/system/cpu/smt/active").and_then(|text| text.trim().parse().ok());
    let pages = read("/sys/kernel/mm/transparent_hugepage/enabled");
    let modes = ["[never]", "[madvise]", "[always]"];
    let huge_pages = pages.and_then(|text| modes.iter().position(|mode| text.contains(mode)));
    let facts = [("smt", smt), ("huge_pages", huge_pages.map(|mode| mode as u64))];
    facts.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect()
}

/// Ties each thread of a pool to a processor of its own that this process may use.
///
/// # Errors
/// If there are more threads than such processors, and what the system says.
#[cfg(target_os = "linux")]
pub(super) fn pin(pool: &rayon::ThreadPool) -> Result<()> {
    use anyhow::Context;
    use nix::sched::{CpuSet, sched_getaffinity, sched_setaffinity};
    use nix::unistd::Pid;

    use crate::options::OptionError;

    let this_thread = Pid::from_raw(0);
    let allowed = sched_getaffinity(this_thread).context("asking which processors may be used")?;
    let processors: Vec<usize> =
        (0..CpuSet::count()).filter(|&processor| allowed.is_set(processor) == Ok(true)).collect();
    let threads = pool.current_num_threads();
    if threads > processors.len() {
        let error = OptionError::conflict(format!(
            "--pin gives each thread a processor of its own, but {threads} threads may use {}; ask for fewer with --threads, or leave --pin out",
            processors.len()
        ));
        return Err(error.into());
    }
    let tied = pool.broadcast(|thread| {
        let mut set = CpuSet::new();
        set.set(processors[thread.index()])?;
        sched_setaffinity(this_thread, &set)
    });
    tied.into_iter().collect::<Result<(), _>>().context("tying threads to processors (--pin)")
}

/// Other systems are not asked; options refuse `--pin` there.
///
/// # Errors
/// None.
#[cfg(not(target_os = "linux"))]
pub(super) fn pin(_: &rayon::ThreadPool) -> Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processors_of_one_name_are_told_apart_by_family_and_model() {
        let facts = "processor\t: 0\ncpu family\t: 25\nmodel\t\t: 17\nmodel name\t: AMD EPYC\n";
        assert_eq!(family_and_model(facts).as_deref(), Some("family 25, model 17"));
        assert_eq!(family_and_model("processor\t: 0\nBogoMIPS\t: 50.00\n"), None);
    }
}
