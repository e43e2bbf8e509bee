//! Workers and snapshots of components that are linked in, on both clocks.
#![expect(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "tests")]

use hal_component::{
    Builder, Component, Error, In, Out, Period, Plain, RingReader, RingWriter, Snapshot, Touch,
    Update, Work,
    abi::{ArgSpec, arg, component_flags},
};
use hal_engine::{ClockKind, Engine, Options};
use hal_protocol::{
    Client, Edit, Failure, FaultInfo, Kind, Link, Place, Reply, Request, StatusInfo, Value,
    WorkerInfo, WorkerState,
};
use std::{
    io::Read,
    os::unix::net::UnixStream,
    path::PathBuf,
    sync::{
        Mutex,
        atomic::{AtomicU32, Ordering::Relaxed},
        mpsc,
    },
};

const PERIOD_NS: i64 = 1_000_000;
const PLAN_NS: i64 = 10_000_000;
const ITEMS: u32 = 20;
/// Number of points that the ring between worker and function holds.
const RING_LEN: usize = 64;

/// Values of the pin `planner.how`.
const PANICS: i32 = 1;
const BLOCKS: i32 = 2;

/// Files that a blocked worker reads, by the argument `file=` of its component.
static FILES: Mutex<Vec<(i64, UnixStream)>> = Mutex::new(Vec::new());
/// Numbers of live states of workers, and of stop actions run, by the same argument.
static LIVE: [AtomicU32; 16] = [const { AtomicU32::new(0) }; 16];
static STOPS: [AtomicU32; 16] = [const { AtomicU32::new(0) }; 16];

#[derive(Clone, Copy, Plain)]
struct Point {
    /// Position in machine units.
    position: f64,
    /// Number of the point.
    number: u64,
}

/// Computes points ahead of `planner.follow`.
#[derive(Touch)]
struct Plan {
    how: In<i32>,
    points: RingWriter<Point>,
    #[state]
    next: u64,
    #[state]
    file: i64,
}

impl Work for Plan {
    fn work(&mut self, items: u32) -> u32 {
        match self.how.get() {
            PANICS => panic!("told to"),
            BLOCKS => {
                let files = FILES.lock().unwrap();
                let file = files.iter().find(|(n, _)| *n == self.file).map(|(_, f)| f);
                let mut file = file.unwrap().try_clone().unwrap();
                drop(files);
                let mut byte = [0];
                file.read_exact(&mut byte).unwrap_or_default();
            }
            _ => {}
        }
        for done in 0..items {
            let position = (self.next as f64 * 0.1).sin();
            if self.points.put(Point { position, number: self.next }).is_err() {
                return done;
            }
            self.next += 1;
        }
        items
    }
}

impl Drop for Plan {
    fn drop(&mut self) {
        LIVE[usize::try_from(self.file).unwrap()].fetch_sub(1, Relaxed);
    }
}

#[derive(Clone, Copy, Plain)]
struct Status {
    /// Number of cycles.
    cycles: u64,
    /// The same number as a float, and its negative.
    twice: [f64; 2],
    /// True in even cycles.
    even: bool,
    /// A value that is not finite.
    nan: f64,
}

/// Takes one point in each cycle.
#[derive(Touch)]
struct Follow {
    position: Out<f64>,
    taken: Out<u64>,
    cycles: Out<u64>,
    points: RingReader<Point>,
    status: Snapshot<Status>,
}

impl Update for Follow {
    fn update(&mut self, _: Period) {
        if let Some(point) = self.points.take() {
            assert_eq!(point.number, self.taken.get());
            self.taken.set(point.number + 1);
            self.position.set(point.position);
        }
        let cycles = self.cycles.get() + 1;
        self.cycles.set(cycles);
        let x = cycles as f64;
        let even = cycles.is_multiple_of(2);
        self.status.set(&Status { cycles, twice: [x, -x], even, nan: f64::NAN });
    }
}

struct Planner;

impl Component for Planner {
    const NAME: &'static str = "planner";
    const DOC: &'static str = "A worker that plans, and a function that follows.";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &ArgSpec::new(arg::INT, "file", "File that a blocked worker reads").or("0"),
        &ArgSpec::new(arg::BIT, "broken", "Whether creation fails after the worker").or("0"),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let file = b.arg_int("file").unwrap();
        let at = usize::try_from(file).unwrap();
        let how = b.item("planner.how", "What the worker does", 0)?;
        let position = b.item("planner.position", "Position in machine units", 0.0)?;
        let taken = b.item("planner.taken", "Points taken", 0)?;
        let cycles = b.item("planner.cycles", "Cycles", 0)?;
        let (writer, points) = b.ring(RING_LEN);
        let status = b.snapshot("planner.status", 3, "State of the follower in each cycle.")?;
        LIVE[at].fetch_add(1, Relaxed);
        let plan = Plan { how, points: writer, next: 0, file };
        b.worker("planner.plan", "Computes points ahead", PLAN_NS, ITEMS, plan)?;
        b.function(
            "planner.follow",
            "Follows",
            Follow { position, taken, cycles, points, status },
        )?;
        b.on_stop(move || {
            STOPS[at].fetch_add(1, Relaxed);
        })?;
        if b.arg_int("broken") == Some(1) {
            return Err(Error::new("told to fail"));
        }
        b.thread("servo", PERIOD_NS)
    }
}

hal_component::export!(Planner);

fn options(clock: ClockKind, place: Place) -> Options {
    Options::simulated(place, clock)
}

fn engine(clock: ClockKind) -> Engine {
    let place = Place::at("/nonexistent", "workers").unwrap();
    let mut e = Engine::without_socket(options(clock, place)).unwrap();
    e.add_static(&HAL_LIBRARY);
    e
}

fn load(args: &[&str]) -> Request {
    let args = args.iter().map(|a| (*a).to_owned()).collect();
    Request::Load { module: "planner".to_owned(), args }
}

fn add() -> Request {
    let (funct, thread) = ("planner.follow".to_owned(), "servo".to_owned());
    Request::AddFunct { funct, thread, position: -1, init: false }
}

fn unload() -> Request {
    Request::Unload { name: "planner".to_owned() }
}

/// Loads the component, with this file for its worker, and starts the threads.
fn started(clock: ClockKind, file: i64) -> Engine {
    let mut e = engine(clock);
    e.call(load(&[&format!("file={file}")])).unwrap();
    e.call(add()).unwrap();
    e.call(Request::Start).unwrap();
    e
}

fn get(e: &mut Engine, name: &str) -> Value {
    match e.call(Request::Get { name: name.to_owned() }).unwrap() {
        Reply::Value(value) => value,
        other => panic!("{other:?}"),
    }
}

fn count(e: &mut Engine, name: &str) -> u64 {
    match get(e, name) {
        Value::U64(n) => n,
        other => panic!("{other:?}"),
    }
}

fn set_how(e: &mut Engine, how: i32) {
    let (name, value) = ("planner.how".to_owned(), how.to_string());
    e.call(Request::Set { name, value }).unwrap();
}

fn status(e: &mut Engine) -> StatusInfo {
    match e.call(Request::Status).unwrap() {
        Reply::Status(status) => *status,
        other => panic!("{other:?}"),
    }
}

fn worker(e: &mut Engine) -> WorkerInfo {
    let all = Request::List { kind: Kind::Workers, patterns: Vec::new(), ty: None };
    match e.call(all).unwrap() {
        Reply::Workers(list) => list.into_iter().next().unwrap(),
        other => panic!("{other:?}"),
    }
}

/// Lets time pass until a condition holds.
fn until(e: &mut Engine, what: &str, holds: impl Fn(&mut Engine) -> bool) {
    let is_virtual = status(e).clock == "virtual";
    for _ in 0..10_000 {
        if holds(e) {
            return;
        }
        e.call(if is_virtual {
            Request::Run { ns: PERIOD_NS.unsigned_abs() }
        } else {
            Request::Idle { ms: 2, flow: false }
        })
        .unwrap();
    }
    panic!("never: {what}");
}

fn refused(e: &mut Engine, request: Request) -> String {
    let Failure { text, .. } = e.call(request).unwrap_err();
    text
}

/// Returns a file whose reader waits until the returned end writes or closes it.
fn blocking_file(number: i64) -> UnixStream {
    let (mine, theirs) = UnixStream::pair().unwrap();
    FILES.lock().unwrap().push((number, theirs));
    mine
}

#[test]
fn on_the_virtual_clock_a_step_is_made_at_each_multiple_of_the_period() {
    let run = || {
        let mut e = started(ClockKind::Virtual, 1);
        let mut seen = Vec::new();
        for _ in 0..200 {
            e.call(Request::Run { ns: PERIOD_NS.unsigned_abs() }).unwrap();
            let info = worker(&mut e);
            let position = get(&mut e, "planner.position").bits();
            seen.push((info.steps, info.items, count(&mut e, "planner.taken"), position));
        }
        e.close();
        seen
    };
    let seen = run();
    assert_eq!(seen, run(), "the same bytes");
    // One step after 10 ms. Before it nothing was planned, and from then on a point is taken in each cycle.
    let steps = |ms: usize| seen[ms - 1].0;
    assert_eq!([steps(9), steps(10), steps(19), steps(20), steps(200)], [0, 1, 1, 2, 20]);
    assert_eq!((seen[9].1, seen[9].2), (u64::from(ITEMS), 0), "20 points are planned, none taken");
    assert_eq!((seen[10].2, seen[199].2), (1, 190));
    // 20 points are added in the time in which 10 are taken, until the ring is full.
    let most = seen.iter().map(|s| s.1 - s.2).max().unwrap();
    assert_eq!(most, RING_LEN as u64);
}

#[test]
fn a_worker_that_panics_stops_motion_and_status_names_it() {
    for (clock, file) in [(ClockKind::Virtual, 2), (ClockKind::Real, 3)] {
        let mut e = started(clock, file);
        let at = usize::try_from(file).unwrap();
        until(&mut e, "it follows", |e| count(e, "planner.taken") > 3);
        assert_eq!(STOPS[at].load(Relaxed), 0);
        e.take_messages();
        set_how(&mut e, PANICS);
        until(&mut e, "the fault is seen", |e| status(e).fault.is_some());
        let s = status(&mut e);
        let fault = s.fault.unwrap();
        assert!(fault.cause.starts_with("told to"), "{fault:?}");
        assert!(!s.running);
        assert_eq!(
            FaultInfo { cause: String::new(), ..fault.clone() },
            FaultInfo {
                component: "planner".into(),
                funct: "planner.plan".into(),
                thread: String::new(),
                cause: String::new(),
            }
        );
        assert_eq!(
            e.take_messages().last().unwrap(),
            &format!(
                "worker 'planner.plan' of component 'planner' failed: {}; all threads are stopped \
                 and outputs are at their safe levels",
                fault.cause
            )
        );
        assert!(STOPS[at].load(Relaxed) > 0, "outputs are safe");
        assert_eq!(worker(&mut e).state, WorkerState::Failed);
        let cycles = count(&mut e, "planner.cycles");
        set_how(&mut e, 0);
        assert_eq!(
            refused(&mut e, Request::Start),
            "worker 'planner.plan' has failed: threads stay stopped"
        );
        if clock == ClockKind::Virtual {
            e.call(Request::Run { ns: 100_000_000 }).unwrap();
        } else {
            e.call(Request::Idle { ms: 20, flow: false }).unwrap();
        }
        assert_eq!(count(&mut e, "planner.cycles"), cycles, "no cycle begins");
        // A new component of the same name is not the one that failed.
        e.call(unload()).unwrap();
        assert_eq!((status(&mut e).fault, LIVE[at].load(Relaxed)), (None, 0));
        e.call(load(&[&format!("file={file}")])).unwrap();
        e.call(add()).unwrap();
        e.call(Request::Start).unwrap();
        until(&mut e, "it follows again", |e| count(e, "planner.taken") > 3);
        assert!(e.close_checked());
        assert_eq!(LIVE[at].load(Relaxed), 0);
    }
}

#[test]
fn a_worker_that_waits_for_a_file_delays_no_thread_and_is_not_unloaded() {
    let mut file = blocking_file(4);
    let mut e = started(ClockKind::Real, 4);
    until(&mut e, "it follows", |e| count(e, "planner.taken") > 3);
    set_how(&mut e, BLOCKS);
    until(&mut e, "it waits", |e| worker(e).state == WorkerState::Working);
    let steps = worker(&mut e).steps;
    let before = count(&mut e, "planner.cycles");
    until(&mut e, "cycles run on", |e| count(e, "planner.cycles") > before + 100);
    assert_eq!((worker(&mut e).state, worker(&mut e).steps), (WorkerState::Working, steps));
    assert_eq!(
        refused(&mut e, unload()),
        "worker 'planner.plan' of component 'planner' does not return"
    );
    // The refusal has changed nothing.
    let before = count(&mut e, "planner.cycles");
    until(&mut e, "cycles run on", |e| count(e, "planner.cycles") > before + 10);
    set_how(&mut e, 0);
    std::io::Write::write_all(&mut file, &[1]).unwrap();
    until(&mut e, "steps go on", |e| worker(e).steps > steps + 2);
    e.call(unload()).unwrap();
    assert_eq!(LIVE[4].load(Relaxed), 0, "the state is freed");
    assert!(e.close_checked());
}

#[test]
fn the_end_of_an_instance_waits_for_no_file() {
    let file = blocking_file(5);
    let mut e = started(ClockKind::Real, 5);
    set_how(&mut e, BLOCKS);
    until(&mut e, "it waits", |e| worker(e).state == WorkerState::Working);
    assert!(!e.close_checked(), "an instance that leaves a worker behind says so");
    assert_eq!(LIVE[5].load(Relaxed), 1, "the worker still uses its state");
    drop(file);
}

#[test]
fn a_load_that_is_refused_or_only_tried_runs_no_worker() {
    for clock in [ClockKind::Virtual, ClockKind::Real] {
        let mut e = engine(clock);
        assert_eq!(refused(&mut e, load(&["file=6", "broken=1"])), "planner: told to fail");
        assert_eq!(LIVE[6].load(Relaxed), 0);
        let edits = vec![Edit { file: 0, line: 1, request: load(&["file=6"]) }];
        let tried = Request::Apply { files: vec!["m".to_owned()], edits, dry: true };
        assert!(matches!(e.call(tried).unwrap(), Reply::Applied { .. }));
        assert_eq!(LIVE[6].load(Relaxed), 0);
        assert!(status(&mut e).workers.is_empty());
        e.call(load(&["file=6"])).unwrap();
        let all = Request::List { kind: Kind::Workers, patterns: vec!["x".into()], ty: None };
        assert_eq!(e.call(all).unwrap(), Reply::Workers(Vec::new()));
        assert_eq!(status(&mut e).workers.len(), 1);
        assert!(e.close_checked());
        assert_eq!(LIVE[6].load(Relaxed), 0);
    }
}

#[test]
fn a_snapshot_is_the_record_of_one_cycle() {
    let mut e = started(ClockKind::Virtual, 7);
    let snapshot = |e: &mut Engine| match e
        .call(Request::Snapshot { name: "planner.status".to_owned() })
        .unwrap()
    {
        Reply::Snapshot(snapshot) => *snapshot,
        other => panic!("{other:?}"),
    };
    assert_eq!(snapshot(&mut e).records, 0);
    e.call(Request::Run { ns: 7_000_000 }).unwrap();
    let values = snapshot(&mut e);
    assert_eq!((values.info.version, values.records), (3, 7));
    assert_eq!(values.info.owner_name, "planner");
    let names: Vec<_> = values.info.fields.iter().map(|f| (f.name.as_str(), f.count)).collect();
    assert_eq!(names, [("cycles", 1), ("twice", 2), ("even", 1), ("nan", 1)]);
    assert_eq!(
        values.values,
        [
            vec![Value::U64(7)],
            vec![Value::Float(7.0), Value::Float(-7.0)],
            vec![Value::Bit(false)],
            vec![Value::Float(f64::NAN)],
        ]
    );
    let e2 = refused(&mut e, Request::Snapshot { name: "planner.state".to_owned() });
    assert_eq!(e2, "snapshot 'planner.state' not found");
    let e3 = refused(&mut e, Request::MapSnapshot { name: "planner.status".to_owned() });
    assert_eq!(e3, "pages go to programs: ask for them on the socket");
    e.call(unload()).unwrap();
    let gone = refused(&mut e, Request::Snapshot { name: "planner.status".to_owned() });
    assert_eq!(gone, "snapshot 'planner.status' not found");
    assert!(e.close_checked());
}

/// Serves an engine on a socket, in a thread of its own.
fn served(name: &str) -> (Place, std::thread::JoinHandle<()>) {
    let folder: PathBuf = std::env::temp_dir().join(format!("hal-{name}-{}", std::process::id()));
    let place = Place::at(folder, name).unwrap();
    let (there, (ready, is_ready)) = (place.clone(), mpsc::channel());
    let thread = std::thread::spawn(move || {
        let mut e = Engine::new(options(ClockKind::Real, there)).unwrap();
        e.add_static(&HAL_LIBRARY);
        e.call(load(&["file=8"])).unwrap();
        e.call(add()).unwrap();
        e.call(Request::Start).unwrap();
        ready.send(()).unwrap();
        e.serve(None);
        assert!(e.close_checked());
    });
    is_ready.recv().unwrap();
    (place, thread)
}

#[test]
fn programs_read_whole_records_from_the_page_while_the_machine_runs() {
    let (place, thread) = served("snapshots");
    let mut client = Client::connect(&place, "").unwrap();
    let page = client.snapshot("planner.status").unwrap();
    assert_eq!(page.info().version, 3);
    let (mut values, mut last, mut changes) = (Vec::new(), 0, 0);
    while changes < 200 {
        let Some(records) = page.read(&mut values) else { continue };
        if records == 0 {
            continue;
        }
        let x = records as f64;
        let expected = [
            Value::U64(records),
            Value::Float(x),
            Value::Float(-x),
            Value::Bit(records.is_multiple_of(2)),
            Value::Float(f64::NAN),
        ];
        assert_eq!(values, expected);
        assert!(records >= last);
        changes += u32::from(records != last);
        last = records;
    }
    // A page outlives its component: its last record stays.
    client.call(unload()).unwrap();
    let kept = page.read(&mut values).unwrap();
    assert_eq!(page.read(&mut values), Some(kept));
    // Without threads, the instance ends.
    thread.join().unwrap();
    assert_eq!(page.read(&mut values), Some(kept));
    std::fs::remove_dir_all(
        std::env::temp_dir().join(format!("hal-snapshots-{}", std::process::id())),
    )
    .unwrap_or_default();
}
