//! The state file: the presented image, and the jobs on it with their ages.

use crate::{bay::Side, error::StorageError, name::is_same};
use core::fmt;

/// Largest number of jobs in a state file.
pub const MOST_JOBS: usize = 4096;

/// Reason why a line of the state file is wrong.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum WrongLedger {
    /// Not UTF-8.
    Encoding,
    /// The first line is not `presented a` or `presented b`.
    Presented,
    /// A line is not `job AGE ready NAME` or `job AGE finished NAME`.
    Job,
    /// There are more than [`MOST_JOBS`] jobs.
    Jobs,
}

impl fmt::Display for WrongLedger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Encoding => f.write_str("it is not UTF-8"),
            Self::Presented => f.write_str("must be 'presented a' or 'presented b'"),
            Self::Job => {
                f.write_str("must be 'job NUMBER ready NAME' or 'job NUMBER finished NAME'")
            }
            Self::Jobs => write!(f, "there are more than {MOST_JOBS} jobs"),
        }
    }
}

/// Job on the presented image.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct StoredJob {
    /// Name of its file.
    pub name: String,
    /// Number of the job, which grows with each job.
    pub number: u64,
    /// True if the job may be deleted when the image is full.
    pub is_finished: bool,
}

/// Contents of the state file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Ledger {
    /// The presented image.
    pub presented: Side,
    /// Jobs, the oldest first.
    pub jobs: Vec<StoredJob>,
}

impl Ledger {
    /// Reads a state file.
    ///
    /// # Errors
    /// A line is wrong.
    pub fn parse(bytes: &[u8]) -> Result<Self, StorageError> {
        let fail = |line, why| StorageError::Ledger(line, why);
        let text = core::str::from_utf8(bytes).map_err(|_| fail(1, WrongLedger::Encoding))?;
        let mut lines = text.lines().enumerate();
        let presented = match lines.next() {
            Some((_, "presented a")) => Side::A,
            Some((_, "presented b")) => Side::B,
            _ => return Err(fail(1, WrongLedger::Presented)),
        };
        let mut jobs: Vec<StoredJob> = Vec::new();
        for (at, line) in lines {
            if jobs.len() >= MOST_JOBS {
                return Err(fail(at + 1, WrongLedger::Jobs));
            }
            jobs.push(job(line).ok_or_else(|| fail(at + 1, WrongLedger::Job))?);
        }
        jobs.sort_by_key(|job| job.number);
        Ok(Self { presented, jobs })
    }

    /// Returns the state file.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        let side = if self.presented == Side::A { "a" } else { "b" };
        let mut text = format!("presented {side}\n");
        for StoredJob { name, number, is_finished } in &self.jobs {
            let state = if *is_finished { "finished" } else { "ready" };
            text.push_str(&format!("job {number} {state} {name}\n"));
        }
        text.into_bytes()
    }

    /// Returns a job by its name.
    #[must_use]
    pub fn job(&self, name: &str) -> Option<&StoredJob> {
        self.jobs.iter().find(|job| is_same(&job.name, name))
    }
}

fn job(line: &str) -> Option<StoredJob> {
    let mut words = line.strip_prefix("job ")?.splitn(3, ' ');
    let number = words.next()?.parse().ok().filter(|n: &u64| *n < u64::MAX)?;
    let is_finished = match words.next()? {
        "ready" => false,
        "finished" => true,
        _ => return None,
    };
    let name = words.next().filter(|n| crate::safe_name(n).as_deref() == Ok(n))?;
    Some(StoredJob { name: name.to_owned(), number, is_finished })
}
