//! Stops, and requests that wait.

use super::{
    Arc, Code, Ending, Engine, Error, Orders, Reply, Request, STOPPED,
    line::{MAX_ENDS, MAX_WAITING, Next, RequestLine, SPACING},
    lock,
};
use hal_protocol::{Answer, CommandInfo, Stop};
use std::{
    sync::{
        Mutex,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
    time::Duration,
};
use tokio::{runtime, time::Instant};

/// Commands of a machine with everything.
pub(crate) const ALL: &[&str] = &[
    "motion.jog",
    "motion.disable",
    "motion.abort",
    "motion.pause",
    "iocontrol.estop",
    "iocontrol.abort",
    "iocontrol.estop-reset",
    "task.run",
    "task.mode",
    "task.on",
    "task.estop-reset",
    "task.home",
    "task.open",
    "task.run-from",
    "task.recover",
    "task.confirm",
    "task.resume",
    "task.step",
    "task.mdi",
    "task.optional-stop",
    "task.block-delete",
    "task.feed-override",
    "task.rapid-override",
    "task.spindle-override",
];

/// Returns the orders of a machine with these commands.
pub(crate) fn orders(names: &[&str]) -> Orders {
    let info = |name: &&str| CommandInfo {
        name: (*name).to_owned(),
        doc: String::new(),
        args: Vec::new(),
    };
    Orders::of(&names.iter().map(info).collect::<Vec<_>>()).unwrap()
}

/// Returns an answer of these lines.
pub(crate) fn answer(lines: &[&str]) -> Reply {
    let lines = lines.iter().map(|line| (*line).to_owned()).collect();
    Reply::Answer(Answer { lines, ticket: None, awaited: false })
}

impl Engine {
    /// Returns the way to an engine of a machine with everything that answers so.
    pub(crate) fn that(
        answer: impl FnMut(Request) -> Result<Reply, Error> + Send + 'static,
    ) -> Self {
        Self::of(ALL, answer)
    }

    /// Ends it, as the end of the engine does.
    pub(crate) fn end(&self) {
        self.line().end();
    }

    /// Returns the way to an engine of a machine with these commands that answers so.
    pub(crate) fn of(
        commands: &[&str],
        mut answer: impl FnMut(Request) -> Result<Reply, Error> + Send + 'static,
    ) -> Self {
        let call = move |request| match request {
            Request::List { kind: hal_protocol::Kind::Components, .. } => Some(Ok(Reply::Done)),
            request => Some(answer(request)),
        };
        Self::start(orders(commands), Vec::new(), call).unwrap()
    }
}

#[test]
fn stops_go_before_everything_and_refuse_what_begins_motion() {
    let (mut line, now) = (RequestLine::default(), Instant::now());
    let before = line.stops();
    drop(line.join(Request::Ready, Some(before)).unwrap());
    drop(line.join(Request::Leave, None).unwrap());
    // The end of a jog ends no program that starts.
    drop(line.join_end(Request::Ready).unwrap());
    drop(line.join(Request::Ready, Some(line.stops())).unwrap());
    drop(line.stop(Ending::Machine(Stop::Abort)).unwrap());
    drop(line.stop(Ending::Machine(Stop::Estop)).unwrap());
    let late = line.join(Request::Ready, Some(before)).unwrap_err();
    assert_eq!((late.code, late.text.as_str()), (Code::Conflict, STOPPED));
    drop(line.join(Request::Ready, Some(line.stops())).unwrap());
    let mut told = Vec::new();
    loop {
        told.push(match line.next(now) {
            Next::Stop(Ending::Machine(stop), _) => stop.name(),
            Next::Stop(Ending::Robot(name), _) => name,
            Next::Job(_) => "job",
            Next::Refuse(_) => "refused",
            Next::Wait(_) => break,
            Next::End => unreachable!(),
        });
    }
    assert_eq!(told, ["estop", "abort", "refused", "job", "job", "refused", "job"]);
}

#[test]
fn stops_in_a_burst_are_one_and_none_is_lost() {
    let (mut line, mut now) = (RequestLine::default(), Instant::now());
    let abort = Ending::Machine(Stop::Abort);
    let mut sent = 0;
    for n in 0..10_000 {
        drop(line.stop(abort).unwrap());
        let is_sent = matches!(line.next(now), Next::Stop(..));
        sent += u32::from(is_sent);
        assert!(n > 0 || is_sent, "the first goes at once");
        now += Duration::from_micros(100);
    }
    // A second, and what was asked for last goes too.
    assert_eq!(sent, 50);
    now -= Duration::from_millis(1);
    drop(line.join(Request::Ready, Some(line.stops())).unwrap());
    let Next::Wait(Some(rest)) = line.next(now) else { panic!("a start overtakes its stop") };
    assert!(rest <= SPACING);
    assert!(matches!(line.next(now + rest), Next::Stop(..)));
    assert!(matches!(line.next(now + rest), Next::Job(_)));
}

#[test]
fn there_is_room_for_stops_and_ends_of_jogs_whatever_waits() {
    let mut line = RequestLine::default();
    for _ in 0..MAX_WAITING {
        drop(line.join(Request::Ready, None).unwrap());
    }
    assert_eq!(line.join(Request::Ready, None).unwrap_err().code, Code::TooMany);
    for _ in 0..MAX_ENDS {
        drop(line.join_end(Request::Ready).unwrap());
    }
    line.join_end(Request::Ready).unwrap_err();
    for _ in 0..1000 {
        drop(line.stop(Ending::Machine(Stop::Estop)).unwrap());
    }
    line.end();
    let code = line.stop(Ending::Machine(Stop::Estop)).unwrap_err().code;
    assert_eq!((code, line.join(Request::Ready, None).unwrap_err().code), {
        (Code::NoEngine, Code::NoEngine)
    });
}

#[test]
fn every_part_of_a_stop_is_sent_although_one_is_refused() {
    let told = Arc::new(Mutex::new(Vec::new()));
    let tell = told.clone();
    let engine = Engine::that(move |request| {
        let Request::Command { name, .. } = request else { return Ok(Reply::Done) };
        lock(&tell).push(name.clone());
        match name.as_str() {
            "iocontrol.estop" => Err(Error::new(Code::Refused, "it does not open")),
            _ => Ok(answer(&[])),
        }
    });
    let runtime = runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let stopped = runtime.block_on(engine.stop(Ending::Machine(Stop::Estop))).unwrap();
    assert_eq!(*lock(&told), ["iocontrol.estop", "motion.disable"]);
    let ends: Vec<_> = stopped.0.iter().map(|(name, end)| (name.as_str(), end.is_ok())).collect();
    assert_eq!(ends, [("iocontrol.estop", false), ("motion.disable", true)]);
}

#[test]
fn a_machine_that_has_changed_is_stopped_as_it_is_now() {
    // A robot is loaded after the panel has started.
    let told = Arc::new(Mutex::new(Vec::new()));
    let tell = told.clone();
    let info =
        |name: &str| CommandInfo { name: name.to_owned(), doc: String::new(), args: Vec::new() };
    let component = |id| hal_protocol::ComponentInfo {
        id,
        name: format!("c{id}"),
        realtime: true,
        pid: None,
        state: hal_protocol::ComponentState::Ready,
        args: None,
        foreign: None,
    };
    let names = ["motion.jog", "motion.disable", "motion.abort", "motion.pause"];
    let call = move |request| {
        Some(Ok(match request {
            Request::List { kind: hal_protocol::Kind::Components, .. } => {
                Reply::Components(vec![component(1), component(2)])
            }
            Request::List { .. } => {
                let robot = ["robot.run", "robot.stop", "robot.pause"];
                Reply::Commands(names.iter().chain(&robot).map(|name| info(name)).collect())
            }
            Request::Command { name, .. } => {
                lock(&tell).push(name);
                answer(&[])
            }
            _ => Reply::Done,
        }))
    };
    let engine = Engine::start(orders(&names), vec![(1, "c1".to_owned())], call).unwrap();
    let runtime = runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(engine.stop(Ending::Machine(Stop::Abort))).unwrap();
    assert_eq!(*lock(&told), ["motion.abort", "robot.stop"]);
    assert_eq!(engine.outdated(), None);
}

/// A thousand stops of all kinds by many at once, among requests that fill the line: each is sent after it was asked for.
#[test]
fn a_thousand_stops_under_load_are_all_sent() {
    let sent: Arc<[AtomicU64; 4]> = Arc::default();
    let tell = sent.clone();
    let names = ["motion.disable", "motion.abort", "motion.pause", "iocontrol.estop"];
    let engine = Engine::that(move |request| {
        if let Request::Command { name, .. } = &request
            && let Some(n) = names.iter().position(|own| own == name)
        {
            tell[n].fetch_add(1, Relaxed);
        }
        Ok(answer(&[]))
    });
    let runtime = runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
    runtime.unwrap().block_on(async {
        let mut work = Vec::new();
        for task in 0..20_usize {
            let (engine, sent) = (engine.clone(), sent.clone());
            work.push(tokio::spawn(async move {
                for n in 0..50_usize {
                    for _ in 0..20 {
                        // Who is refused has asked too early; the line is full on purpose.
                        let load = engine.clone();
                        tokio::spawn(async move { drop(load.call(Request::Ready).await) });
                    }
                    let stop = Stop::ALL[(task * 7 + n * 13 + n / 3) % 4];
                    let counts = || match stop {
                        Stop::Estop => vec![3, 0],
                        Stop::Off => vec![0],
                        Stop::Abort => vec![1],
                        Stop::Pause => vec![2],
                    };
                    let before: Vec<_> = counts().iter().map(|n| sent[*n].load(Relaxed)).collect();
                    let stopped = engine.stop(Ending::Machine(stop)).await.unwrap();
                    assert!(stopped.0.iter().all(|(_, end)| end.is_ok()));
                    for (n, before) in counts().into_iter().zip(before) {
                        assert!(sent[n].load(Relaxed) > before, "{stop:?} is lost");
                    }
                }
            }));
        }
        for task in work {
            task.await.unwrap();
        }
    });
    let all: u64 = sent.iter().map(|n| n.load(Relaxed)).sum();
    assert!(all <= 4 * 2000, "stops in a burst are one: {all}");
}
