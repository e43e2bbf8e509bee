//! PREPARE: the next image is made, written and read back, one file in a step.

use crate::{
    bay::{Bay, Side},
    error::StorageError,
    image,
    plan::ImagePlan,
};
use std::io;

/// Does a step after `done` ones; returns whether there are more. `from` is the presented image, and the other one is written.
pub(crate) fn step(
    bay: &mut impl Bay,
    from: Side,
    plan: &ImagePlan,
    done: usize,
) -> Result<bool, StorageError> {
    let side = from.other();
    let count = plan.kept.len() + plan.added.len();
    let fail = |job: Option<&str>| {
        let job = job.map(Into::into);
        move |e: io::Error| StorageError::Image(side, job, e)
    };
    if done == 0 {
        bay.blank(side).map_err(fail(None))?;
        bay.image(side).and_then(image::format).map_err(fail(None))?;
    } else if done <= count {
        let (name, bytes) = file(bay, from, plan, done - 1)?;
        let disk = bay.image(side).map_err(fail(Some(&name)))?;
        image::write(disk, &name, &bytes).map_err(fail(Some(&name)))?;
    } else if done == count + 1 {
        // What is read back comes from the disk.
        bay.flush(side).map_err(fail(None))?;
        let mut names: Vec<&String> = plan.kept.iter().chain(&plan.added).collect();
        names.sort();
        let found = bay.image(side).and_then(image::list).map_err(fail(None))?;
        if !found.iter().map(|file| &file.name).eq(names) {
            return Err(StorageError::Different(side, "the list of files".into()));
        }
    } else if done <= 2 * count + 1 {
        let (name, bytes) = file(bay, from, plan, done - count - 2)?;
        let most = bytes.len() as u64;
        let disk = bay.image(side).map_err(fail(Some(&name)))?;
        let written = image::read(disk, &name, most).map_err(fail(Some(&name)))?;
        if written != bytes {
            return Err(StorageError::Different(side, name.into()));
        }
    } else {
        return Ok(false);
    }
    Ok(true)
}

/// Returns a file of the next image: its name and its contents.
fn file(
    bay: &mut impl Bay,
    from: Side,
    plan: &ImagePlan,
    at: usize,
) -> Result<(String, Vec<u8>), StorageError> {
    if let Some(name) = plan.kept.get(at) {
        let bytes = bay.image(from).and_then(|disk| image::read(disk, name, image::MOST));
        let fail = |e| StorageError::Image(from, Some(name.as_str().into()), e);
        return Ok((name.clone(), bytes.map_err(fail)?));
    }
    let name = plan.added.get(at - plan.kept.len()).cloned().unwrap_or_default();
    let bytes = waiting_job(bay, &name)?;
    Ok((name, bytes))
}

/// Returns a waiting job.
pub(crate) fn waiting_job(bay: &mut impl Bay, name: &str) -> Result<Vec<u8>, StorageError> {
    let job = bay.job(name);
    job.map_err(|e| StorageError::Keeping(format!("job '{name}'").into(), e))
}
