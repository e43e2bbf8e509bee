//! Results of all tests as `JUnit` XML, for continuous integration servers.
//!
//! Times are machine time, so the same tests always produce the same file.

use super::outcome::Outcome;
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::{path::Path, time::Duration};

/// Returns the text of the file.
pub(super) fn write(outcomes: &[Outcome]) -> Result<String, quick_junit::SerializeError> {
    let mut report = Report::new("haltest");
    let mut suites: Vec<TestSuite> = Vec::new();
    for outcome in outcomes {
        let path = Path::new(&outcome.file);
        let folder = path.parent().map(|p| p.display().to_string()).unwrap_or_default();
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut case = TestCase::new(name, status(outcome));
        case.set_classname(folder.as_str());
        case.set_time(Duration::from_nanos(outcome.machine_ns));
        if !outcome.said.is_empty() {
            case.set_system_out(outcome.said.join("\n"));
        }
        if !suites.iter().any(|s| s.name.as_str() == folder) {
            suites.push(TestSuite::new(folder.as_str()));
        }
        if let Some(suite) = suites.iter_mut().find(|s| s.name.as_str() == folder) {
            suite.add_test_case(case);
        }
    }
    report.add_test_suites(suites);
    report.to_string()
}

fn status(outcome: &Outcome) -> TestCaseStatus {
    let Some(first) = outcome.complaints.first() else { return TestCaseStatus::success() };
    let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
    let all: Vec<String> = outcome.complaints.iter().map(ToString::to_string).collect();
    status.set_message(first.text.as_str()).set_description(all.join("\n"));
    status
}
