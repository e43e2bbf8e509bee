//! Cancellation of a job, at once or at the end of its command.

use super::{LOOK, User, end_lease, finish, number, ticket};
use crate::{
    engine::Ending,
    error::{Code as Kind, Error},
    server::Panel,
    status::Joined,
};
use hal_protocol::{Request, Stop};
use serde_json::{Map, Value as Json, json};
use std::{
    io::Write as _,
    sync::atomic::{AtomicBool, Ordering::Relaxed},
    time::Duration,
};
use tokio::time::{sleep, timeout};

/// Longest wait for the end of the present command of a job that is cancelled.
pub(in crate::teleop) const MAX_END: Duration = Duration::from_secs(60);
/// Number of refused aborts after which the lease is given back.
const MAX_REFUSALS: u32 = 25;

/// Brakes and ends the job: tries until the engine has taken the command, or the job is over. Meanwhile it gives the lease
/// back, so that the job at least ends as `[REMOTE]ON_LOSS` says.
/// With `end`, the longest wait, its present command is executed to its end before.
pub(in crate::teleop) async fn cancel(
    panel: &Panel,
    owner: Option<&User>,
    is_over: &AtomicBool,
    end: Option<Duration>,
) {
    if let Some(most) = end {
        let ended = tokio::select! {
            biased;
            // The next job is another one: there is nothing to cancel.
            () = over(is_over) => return,
            ended = timeout(most, end_command(panel)) => ended,
        };
        let late = || {
            let text = format!("the command has not ended within {} s", most.as_secs_f64());
            Err(Error::new(Kind::Refused, text))
        };
        if let Err(why) = ended.unwrap_or_else(|_| late()) {
            panel.audit.note("teleop", 0, &json!(why.text), Err(&why));
        }
    }
    for n in 1_u32.. {
        let Err(why) = panel.stop(Ending::Machine(Stop::Abort)).await else { return };
        if is_over.load(Relaxed) {
            return;
        }
        if n == 1 {
            panel.audit.note("teleop", 0, &json!("cancel"), Err(&why));
            let text = "the job cannot be cancelled yet, it is tried again";
            // Without standard error there is nowhere else to say it.
            drop(writeln!(std::io::stderr(), "halpanel: teleoperation: {text}: {}", why.text));
        }
        if let Some(owner) = owner.filter(|_| n == MAX_REFUSALS) {
            end_lease(panel, owner).await;
        }
        sleep(LOOK).await;
    }
}

/// Waits until the job is over.
async fn over(is_over: &AtomicBool) {
    while !is_over.load(Relaxed) {
        sleep(LOOK).await;
    }
}

/// Pauses, and goes on to the end of the present command. The job rests there.
async fn end_command(panel: &Panel) -> Result<(), Error> {
    panel.stop(Ending::Machine(Stop::Pause)).await?;
    let Some(line) = paused(panel, |_| true).await else { return Ok(()) };
    let step = Request::Command { name: "task.step".to_owned(), args: Vec::new() };
    let step = panel.engine.call(step).await?;
    if let Some(ticket) = ticket(step) {
        finish(panel, ticket).await.map_err(|why| Error::new(Kind::Refused, why))?;
    }
    // The step has begun; the job rests again behind its line.
    paused(panel, |motion| {
        float(motion, "distance_to_go") == 0.0 || number(motion, "line") != line
    })
    .await;
    Ok(())
}

/// Waits until motion rests in a pause and is so; returns the line there, or nothing if the job has ended.
async fn paused(panel: &Panel, is_so: impl Fn(&Map<String, Json>) -> bool) -> Option<u64> {
    loop {
        {
            let machine = panel.machine.borrow();
            if machine.engine == Joined::Gone {
                return None;
            }
            // A status that cannot be read at this moment is no sign of an end.
            if let (Some(task), Some(motion)) = (&machine.task, &machine.motion) {
                if number(task, "interpreter") == 0 {
                    return None;
                }
                let rests = float(motion, "velocity") == 0.0;
                if rests && motion.get("paused") == Some(&Json::Bool(true)) && is_so(motion) {
                    return Some(number(motion, "line"));
                }
            }
        }
        sleep(LOOK).await;
    }
}

/// Returns a number of a snapshot; NaN if it has none.
fn float(snapshot: &Map<String, Json>, name: &str) -> f64 {
    snapshot.get(name).and_then(Json::as_f64).unwrap_or(f64::NAN)
}
