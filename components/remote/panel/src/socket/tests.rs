//! Pages that nobody uses, with a job and without, on a clock that is turned.

use super::{Connection, Role};
use crate::{
    engine::{Engine, tests::answer},
    server::Panel,
    status::Machine,
};
use serde_json::json;
use std::{sync::Arc, time::Duration};
use tokio::{
    runtime,
    sync::watch,
    time::{Instant, advance},
};

/// Time after which a page that nobody uses only looks.
const IDLE: Duration = Duration::from_mins(30);
/// A second.
const SECOND: Duration = Duration::from_secs(1);

/// Runs a page for so long while a task is in this state; `uses` says whether a person uses it then. Returns the time after which
/// it only looks, and whether it then has the lease.
fn lasts(
    name: &str,
    time: Duration,
    work: impl Fn(Duration) -> u32,
    uses: bool,
) -> (Duration, bool) {
    let (tell, seen) = watch::channel(Arc::default());
    let mut panel = Panel::that(Engine::that(|_| Ok(answer(&["lease=1"]))), name);
    panel.machine = seen;
    let panel = Arc::new(panel);
    let runtime = runtime::Builder::new_current_thread().enable_all().start_paused(true).build();
    let found = runtime.unwrap().block_on(async {
        let (session, _) = panel.sessions.begin("ana", Role::Operator).unwrap();
        let client = panel.clients.enter(&session);
        panel.clients.take(&panel.engine, client, &session, false).await.unwrap();
        let mut page = Connection::new(&panel, session, client);
        let begun = Instant::now();
        while begun.elapsed() < time {
            advance(SECOND).await;
            let task = json!({ "interpreter": work(begun.elapsed()) }).as_object().cloned();
            tell.send_replace(Arc::new(Machine { task, ..Machine::default() }));
            page.used = uses;
            page.second().await.unwrap();
            if page.role == Role::Viewer {
                break;
            }
        }
        (begun.elapsed(), panel.clients.number(client).is_some())
    });
    std::fs::remove_dir_all(panel.place.folder()).unwrap();
    found
}

#[test]
fn a_page_that_nobody_uses_gives_its_lease_back_unless_a_job_runs() {
    let hours = |n| Duration::from_hours(n);
    assert_eq!(lasts("idle-none", hours(2), |_| 0, false), (IDLE + SECOND, false));
    assert_eq!(lasts("idle-used", hours(2), |_| 0, true), (hours(2), true));
    // A job of three hours; half an hour after it the page only looks.
    let job = |at: Duration| u32::from(at <= Duration::from_hours(3));
    assert_eq!(lasts("idle-job", hours(5), job, false), (hours(3) + IDLE + SECOND, false));
    // One that is paused is still there.
    assert_eq!(lasts("idle-pause", hours(3), |_| 2, false), (hours(3), true));
}
