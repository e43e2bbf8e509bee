//! The contents of the next image: the files of the present one, and the waiting jobs.

use crate::{
    error::StorageError,
    image::ImageFile,
    ledger::{Ledger, StoredJob},
    name::is_same,
};

/// Share of the image above which finished jobs are deleted, in percent.
pub const FULL: u64 = 80;

/// Contents of the next image.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ImagePlan {
    /// Files that are copied from the present image.
    pub kept: Vec<String>,
    /// Waiting jobs that are added.
    pub added: Vec<String>,
    /// Finished jobs that are left out.
    pub deleted: Vec<String>,
    /// The jobs with their ages, as the next state file has them.
    pub jobs: Vec<StoredJob>,
}

/// Returns the bytes that an image of this size has for files.
#[must_use]
pub const fn room(size: u64) -> u64 {
    // Two tables of 4 bytes for each 512 bytes, and the first sectors.
    size - size / 32 - (1 << 20)
}

/// Returns the bytes that a file takes on an image of this size: whole clusters.
const fn share(len: u64, size: u64) -> u64 {
    let cluster = match size {
        0..=272_629_760 => 512,
        272_629_761..=8_589_934_592 => 4 << 10,
        _ => 32 << 10,
    };
    len.div_ceil(cluster).saturating_mul(cluster)
}

impl ImagePlan {
    /// Returns the contents of the next image: `present` has the files of the present one, `waiting` the new ones.
    ///
    /// # Errors
    /// All files together, without finished jobs, do not fit.
    pub fn new(
        ledger: &Ledger,
        present: &[ImageFile],
        waiting: &[ImageFile],
        size: u64,
    ) -> Result<Self, StorageError> {
        let is_replaced = |name: &str| waiting.iter().any(|job| is_same(&job.name, name));
        let mut kept: Vec<&ImageFile> = present.iter().filter(|f| !is_replaced(&f.name)).collect();
        let mut deleted = Vec::new();
        let mut bytes: u64 = kept.iter().copied().chain(waiting).map(|f| share(f.len, size)).sum();
        let most = room(size);
        // The ledger has the oldest job first.
        for job in ledger.jobs.iter().filter(|job| job.is_finished) {
            if bytes <= most / 100 * FULL {
                break;
            }
            if let Some(at) = kept.iter().position(|file| is_same(&file.name, &job.name)) {
                let file = kept.remove(at);
                bytes -= share(file.len, size);
                deleted.push(file.name.clone());
            }
        }
        if bytes > most {
            return Err(StorageError::Room(bytes, most));
        }
        let next = ledger.jobs.iter().map(|job| job.number + 1).max().unwrap_or(1);
        let is_kept = |job: &&StoredJob| kept.iter().any(|file| is_same(&file.name, &job.name));
        let mut jobs: Vec<StoredJob> = ledger.jobs.iter().filter(is_kept).cloned().collect();
        let new = waiting.iter().zip(next..);
        jobs.extend(new.map(|(job, number)| StoredJob {
            name: job.name.clone(),
            number,
            is_finished: false,
        }));
        let name = |file: &ImageFile| file.name.clone();
        Ok(Self {
            kept: kept.into_iter().map(name).collect(),
            added: waiting.iter().map(name).collect(),
            deleted,
            jobs,
        })
    }
}
