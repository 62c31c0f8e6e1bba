//! What was checked and what was found.

use rayon::prelude::*;
use serde::Serialize;

/// Findings of one kind that are shown with their place; the others are counted.
const SHOWN: usize = 5;
/// Items that a thread takes at a time.
const ITEMS_PER_TASK: usize = 8192;

/// The outcome of all checks.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// One entry per check, in the order in which they are made.
    pub checks: Vec<Check>,
}

impl Report {
    /// Whether nothing is wrong. Differences that the adapter's arithmetic explains are not wrong.
    pub fn is_ok(&self) -> bool {
        self.problems() == 0
    }

    /// How many things are wrong.
    pub fn problems(&self) -> u64 {
        self.checks.iter().map(|check| check.problems.count).sum()
    }
}

/// The outcome of one check.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Check {
    /// What was checked: `files`, `hits`, ….
    pub name: &'static str,
    /// How many items were looked at, such as arrays or rays.
    pub checked: u64,
    /// What is wrong.
    pub problems: Findings,
    /// Numbers that differ as they may on an adapter without IEEE arithmetic.
    pub differences: Findings,
    /// What could not be checked, and why: what was not kept, is damaged, or is in a source that is missing.
    pub not_checked: Vec<String>,
}

impl Check {
    pub(super) fn new(name: &'static str) -> Self {
        Self { name, ..Self::default() }
    }

    /// Counts one more item, which must be as `is_right` says.
    pub(super) fn require(&mut self, is_right: bool, problem: impl FnOnce() -> String) {
        self.checked += 1;
        if !is_right {
            self.problems.add(problem());
        }
    }

    /// Counts one more item; `problem` says what is wrong with it, if anything.
    pub(super) fn find(&mut self, problem: Option<String>, item: impl FnOnce() -> String) {
        self.require(problem.is_none(), || format!("{}: {}", item(), problem.unwrap_or_default()));
    }

    /// Checks `items` items in parallel; what is wrong with the first few is described.
    pub(super) fn each(
        &mut self,
        items: usize,
        is_right: impl Fn(usize) -> bool + Sync,
        describe: impl Fn(usize) -> String,
    ) {
        self.checked += items as u64;
        self.problems.merge(findings(items, is_right, describe));
    }
}

/// Things that were found: all of them counted, the first few described with their place.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Findings {
    /// How many there are.
    pub count: u64,
    /// The first few.
    pub first: Vec<String>,
}

impl Findings {
    pub(super) fn add(&mut self, finding: String) {
        self.count += 1;
        if self.first.len() < SHOWN {
            self.first.push(finding);
        }
    }

    pub(super) fn merge(&mut self, other: Self) {
        self.count += other.count;
        self.first.extend(other.first);
        self.first.truncate(SHOWN);
    }
}

/// Finds the items of 0..`items` that are not right.
pub(super) fn findings(
    items: usize,
    is_right: impl Fn(usize) -> bool + Sync,
    describe: impl Fn(usize) -> String,
) -> Findings {
    let all = (0..items).into_par_iter().with_min_len(ITEMS_PER_TASK);
    let count = all.filter(|&item| !is_right(item)).count();
    // Once more, as far as the first few: what is right throughout is looked at once.
    let first = (0..items).filter(|&item| !is_right(item)).take(count.min(SHOWN));
    Findings { count: count as u64, first: first.map(describe).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_findings_are_the_first_in_order() {
        let found = findings(1_000_000, |item| item % 100_000 != 7, |item| item.to_string());
        assert_eq!(found.count, 10);
        assert_eq!(found.first, ["7", "100007", "200007", "300007", "400007"]);
    }

    #[test]
    fn problems_fail_and_differences_do_not() {
        let mut check = Check::new("keys");
        check.differences.add("one quantum".into());
        let mut report = Report { checks: vec![check] };
        assert!(report.is_ok());
        report.checks[0].require(false, || "wrong".into());
        assert!(!report.is_ok());
        assert_eq!(report.problems(), 1);
    }
}
