//! Starts that are refused while they are checked, and cancellations that are refused.

use super::{Code, MAX_END, Panel, Reason, Relaxed, Session, Stops, User, cancel, start};
use crate::{
    engine::{Ending, Engine},
    error::{Code as Kind, Error},
    lease::tests::{run, session},
    session::Role,
    status::{Joined, Machine},
};
use hal_protocol::{Answer, Reply, Request, Stop, TicketInfo};
use serde_json::json;
use std::{
    sync::{
        Arc, Mutex,
        atomic::AtomicBool,
        mpsc::{Receiver, channel},
    },
    time::Duration,
};
use tokio::{sync::watch, task::yield_now};

/// Longer than any test, and shorter than the longest check.
const LONG: &[u8] = b"o1 while [1]\n#1=[#1+1]\no1 endwhile\nG1 X50 F500\nM2\n";

/// Returns an engine that does everything, and the names of the commands that it gets.
fn engine() -> (Engine, Receiver<String>) {
    let (tell, told) = channel();
    let engine = Engine::that(move |request| {
        let Request::Command { name, .. } = request else { return Ok(Reply::Done) };
        let lines = vec!["lease=1".to_owned()];
        drop(tell.send(name));
        Ok(Reply::Answer(Answer { lines, ticket: None, awaited: false }))
    });
    (engine, told)
}

/// Returns a machine in a state of the task, and homed.
fn machine(state: u32, jogging: bool) -> Arc<Machine> {
    stopped(state, jogging, 0)
}

/// Returns a machine that was stopped so many times.
fn stopped(state: u32, jogging: bool, stops: u32) -> Arc<Machine> {
    let object = |value: serde_json::Value| value.as_object().cloned();
    let motion = object(json!({ "all_homed": true, "jogging": jogging, "pose": vec![0.0; 9] }));
    let task = object(json!({ "state": state, "interpreter": 0, "jobs": 0, "stops": stops }));
    Arc::new(Machine { engine: Joined::Joined, motion, task, ..Machine::default() })
}

/// Event while the program is read.
#[derive(Clone, Copy, Debug)]
enum Event {
    Estop,
    Jog,
    Forbidden,
    Stop,
    /// A person at the machine aborts, or presses e-stop and switches on again.
    LocalStop,
}

#[test]
fn what_is_stopped_while_a_start_is_checked_does_not_move_afterwards() {
    for (event, code, text) in [
        (Event::Estop, Code::Apagado, "the machine is in e-stop"),
        (Event::Jog, Code::Ocupado, "somebody moves the machine"),
        (Event::Forbidden, Code::Apagado, "remote.allow-motion is FALSE"),
        (Event::Stop, Code::Ocupado, "a stop has come meanwhile"),
        (Event::LocalStop, Code::Ocupado, "a stop has come meanwhile"),
    ] {
        let (engine, told) = engine();
        let (tell, seen) = watch::channel(machine(2, false));
        let mut panel = Panel::that(engine, "start");
        panel.machine = seen;
        let panel = Arc::new(panel);
        panel.heart.allowed.store(true, Relaxed);
        let file = panel.teleop_file();
        let user = User { session: session("ana"), client: 1 };
        let why = run(async {
            let stops = Stops::of(&panel);
            let (work, of) = (panel.clone(), user.clone());
            let begun = tokio::spawn(async move { start(&work, &of, LONG.to_vec(), stops).await });
            while !file.exists() {
                tell.send_replace(machine(2, false));
                yield_now().await;
            }
            match event {
                Event::Estop => drop(tell.send_replace(machine(0, false))),
                Event::Jog => drop(tell.send_replace(machine(2, true))),
                Event::Forbidden => panel.heart.allowed.store(false, Relaxed),
                Event::LocalStop => drop(tell.send_replace(stopped(2, false, 1))),
                Event::Stop => {
                    drop(panel.engine.stop(Ending::Machine(Stop::Abort)).await.unwrap());
                    for _ in 0..100 {
                        yield_now().await;
                    }
                    // The answer would bring the next request, which this stop must not refuse.
                    assert!(!begun.is_finished(), "refused before the status shows the stop");
                    drop(tell.send_replace(stopped(2, false, 1)));
                }
            }
            begun.await.unwrap().unwrap_err()
        });
        assert!(why.code == Some(code) && why.text.starts_with(text), "{event:?}: {why}");
        let stops: &[&str] = if matches!(event, Event::Stop) { &["motion.abort"] } else { &[] };
        assert_eq!(told.try_iter().collect::<Vec<_>>(), stops, "{event:?}");
        std::fs::remove_dir_all(panel.place.folder()).unwrap();
    }
}

#[test]
fn a_stop_before_the_check_begins_counts_too() {
    let (engine, told) = engine();
    let (tell, seen) = watch::channel(machine(2, false));
    let mut panel = Panel::that(engine, "early");
    panel.machine = seen;
    let panel = Arc::new(panel);
    panel.heart.allowed.store(true, Relaxed);
    let user = User { session: session("ana"), client: 1 };
    let begun = run(async {
        let stops = Stops::of(&panel);
        panel.engine.stop(Ending::Machine(Stop::Abort)).await.unwrap();
        let work = panel.clone();
        let begun = tokio::spawn(async move { start(&work, &user, b"M2\n".to_vec(), stops).await });
        // The status of the check is of before the stop; then it shows the stop.
        for _ in 0..100 {
            tell.send_replace(machine(2, false));
            yield_now().await;
        }
        while !begun.is_finished() {
            tell.send_replace(stopped(2, false, 1));
            yield_now().await;
        }
        begun.await.unwrap()
    });
    let text = "a stop has come meanwhile: give the command again";
    assert_eq!(begun.unwrap_err(), Reason::new(Code::Ocupado, text));
    assert_eq!(told.try_iter().collect::<Vec<_>>(), ["motion.abort"]);
    std::fs::remove_dir_all(panel.place.folder()).unwrap();
}

/// Cancels a job with an engine that refuses so many times; returns the commands that the engine got.
fn cancelled(refusals: usize, name: &str) -> Vec<String> {
    let told = Arc::new(Mutex::new(Vec::new()));
    let (tell, mut left) = (told.clone(), refusals);
    let engine = Engine::that(move |request| {
        let Request::Command { name, .. } = request else { return Ok(Reply::Done) };
        let lines = vec!["lease=1".to_owned()];
        tell.lock().unwrap().push(name.clone());
        if name == "motion.abort" && left > 0 {
            left -= 1;
            return Err(Error::new(Kind::Refused, "too many commands wait for the task"));
        }
        Ok(Reply::Answer(Answer { lines, ticket: None, awaited: false }))
    });
    let panel = Panel::that(engine, name);
    let of = Session { cookie: String::new(), user: "ana".to_owned(), role: Role::Operator };
    let user = User { client: panel.clients.enter_without_page(&of), session: of };
    run(async {
        panel.clients.take(&panel.engine, user.client, &user.session, false).await.unwrap();
        cancel(&panel, Some(&user), &AtomicBool::new(false), None).await;
        // After the job there is nothing to cancel.
        cancel(&panel, Some(&user), &AtomicBool::new(true), None).await;
    });
    std::fs::remove_dir_all(panel.place.folder()).unwrap();
    let told = told.lock().unwrap();
    told.clone()
}

#[test]
fn a_cancellation_is_repeated_until_the_engine_takes_it() {
    let told = cancelled(3, "cancel");
    let expected =
        ["remote.take", "remote.beat"].into_iter().chain(["motion.abort"; 5]).collect::<Vec<_>>();
    assert_eq!(told, expected);
    // After a while the lease goes too.
    let told = cancelled(40, "insist");
    let aborts = told.iter().filter(|name| *name == "motion.abort").count();
    let given = told.iter().position(|name| name == "remote.give");
    assert_eq!((aborts, given), (42, Some(27)), "{told:?}");
}

/// Cancels a job at the end of its command, within this time; returns the commands that the engine got. A step never ends.
fn cancelled_at_end(rests: bool, is_over: bool, end: Duration) -> Vec<String> {
    let (tell, told) = channel();
    let engine = Engine::that(move |request| {
        let Request::Command { name, .. } = request else {
            return Ok(Reply::Ticket(TicketInfo::Pending));
        };
        let ticket = (name == "task.step").then_some(1);
        drop(tell.send(name));
        Ok(Reply::Answer(Answer { lines: Vec::new(), ticket, awaited: false }))
    });
    let mut panel = Panel::that(engine, "end");
    let object = |value: serde_json::Value| value.as_object().cloned();
    let velocity = if rests { 0.0 } else { 1.0 };
    let motion = object(json!({ "velocity": velocity, "paused": true, "line": 3 }));
    let task = object(json!({ "state": 2, "interpreter": 2, "jobs": 0 }));
    let machine = Machine { engine: Joined::Joined, motion, task, ..Machine::default() };
    let (_tell, seen) = watch::channel(Arc::new(machine));
    panel.machine = seen;
    run(cancel(&panel, None, &AtomicBool::new(is_over), Some(end)));
    let log = std::fs::read_to_string(panel.place.folder().join("audit")).unwrap();
    let is_noted = log.contains("the command has not ended within ");
    assert_eq!(is_noted, !is_over, "{log}");
    std::fs::remove_dir_all(panel.place.folder()).unwrap();
    told.try_iter().collect()
}

#[test]
fn a_command_that_does_not_end_is_ended_by_the_abort() {
    let short = Duration::from_millis(1);
    assert_eq!(cancelled_at_end(false, false, short), ["motion.pause", "motion.abort"]);
    // A step that moves nothing, as while feed is inhibited. A slow computer needs longer to come there.
    let mut ends = (0..16).map(|n| cancelled_at_end(true, false, short * (1 << n)));
    let told = ends.find(|told| told.iter().any(|name| name == "task.step"));
    let expected = ["motion.pause", "task.step", "motion.abort"].map(str::to_owned);
    assert_eq!(told.as_deref(), Some(&expected[..]));
    // The job is over already.
    assert_eq!(cancelled_at_end(false, true, Duration::MAX), [""; 0]);
    let protocol = concat!(env!("CARGO_MANIFEST_DIR"), "/../teleop/PROTOCOL.md");
    let protocol = std::fs::read_to_string(protocol).unwrap();
    let longest = format!(" {} s", MAX_END.as_secs());
    for place in ["for at most", "has not ended after"] {
        assert!(protocol.contains(&format!("{place}{longest}")), "{place}{longest}");
    }
}
