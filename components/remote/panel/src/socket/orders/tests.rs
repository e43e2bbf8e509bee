//! Order of what is sent, and what each row of the table needs.

use super::{Given, Order, Panel, begin};
use crate::{
    commands::{Action, Args, Effect, ROWS, tests::example},
    engine::{
        Ending, Engine,
        tests::{ALL, answer},
    },
    error::Code,
    lease::tests::run,
    session::{Role, Session},
};
use hal_protocol::{Reply, Request, Stop};
use std::sync::{Arc, Mutex, atomic::Ordering::Relaxed};
use tokio::sync::mpsc;

#[test]
fn the_first_part_of_an_order_precedes_the_order_after_it() {
    let sent = Mutex::new(Vec::new());
    let order = async |n| {
        sent.lock().unwrap().push((n, "first"));
        tokio::task::yield_now().await;
        sent.lock().unwrap().push((n, "second"));
    };
    let mut orders = [Box::pin(order(1)), Box::pin(order(2))];
    for order in &mut orders {
        assert!(!begin(order));
    }
    assert_eq!(*sent.lock().unwrap(), [(1, "first"), (2, "first")]);
}

/// A panel whose engine does everything, and notes its commands.
pub(super) struct Stage {
    pub(super) panel: Arc<Panel>,
    told: Arc<Mutex<Vec<String>>>,
    pub(super) client: u64,
    pub(super) session: Session,
}

impl Stage {
    pub(super) fn new(name: &str) -> Self {
        let told = Arc::new(Mutex::new(Vec::new()));
        let tell = told.clone();
        let more = ["robot.run", "robot.stop", "robot.pause"];
        let commands: Vec<&str> = ALL.iter().copied().chain(more).collect();
        let engine = Engine::of(&commands, move |request| {
            Ok(match request {
                Request::Command { name, .. } => {
                    tell.lock().unwrap().push(name);
                    answer(&["lease=1"])
                }
                // Nobody waits for a tool.
                Request::List { kind: hal_protocol::Kind::Pins, .. } => Reply::Items(Vec::new()),
                _ => Reply::Done,
            })
        });
        let mut panel = Panel::that(engine, name);
        panel.folders = crate::folders::Folders::of(panel.place.folder().to_owned());
        std::fs::write(panel.place.folder().join("a.ngc"), "M2\n").unwrap();
        let (session, _) = panel.sessions.begin("ana", Role::Integrator).unwrap();
        let client = panel.clients.enter(&session);
        Self { panel: Arc::new(panel), told, client, session }
    }

    /// Returns an order that was given when there were so many stops.
    pub(super) fn order(&self, stops: u64) -> Order {
        Order {
            panel: self.panel.clone(),
            session: self.session.clone(),
            client: self.client,
            answers: mpsc::channel(1).0,
            stops,
            given: Given::In(None),
        }
    }

    /// Executes a command that was given when there were so many stops; returns the code of its refusal.
    async fn gives(&self, name: &str, args: &Args, stops: u64) -> Option<Code> {
        self.order(stops).command(1, name, args).await.err().map(|why| why.code)
    }

    fn told(&self) -> Vec<String> {
        core::mem::take(&mut *self.told.lock().unwrap())
    }
}

pub(super) fn args(name: &str) -> Args {
    let given = match name {
        "open" | "robot-load" => serde_json::json!({ "program": "a.ngc" }),
        name => example(name),
    };
    serde_json::from_value(given).unwrap()
}

#[test]
fn every_row_needs_what_its_effect_says() {
    let stage = Stage::new("rows");
    let panel = stage.panel.clone();
    run(async {
        for row in ROWS {
            let (name, args) = (row.name, args(row.name));
            let ends = row.effect == Effect::Ends;
            // A button that answers nothing is refused as that, once it has all that it needs.
            let free = matches!(row.action, Action::ToolChanged).then_some(Code::Conflict);
            let stops = || panel.engine.stops();

            let bare = stage.gives(name, &args, stops()).await;
            assert_eq!(bare, if ends { None } else { Some(Code::Lease) }, "{name} without lease");
            panel.clients.take(&panel.engine, stage.client, &stage.session, false).await.unwrap();
            panel.heart.allowed.store(false, Relaxed);
            let forbidden = stage.gives(name, &args, stops()).await;
            let moves = matches!(row.effect, Effect::Begins | Effect::Powers);
            let wanted = if moves { Some(Code::Remote) } else { free };
            assert_eq!(forbidden, wanted, "{name} without permission");
            panel.heart.allowed.store(true, Relaxed);

            stage.told();
            assert_eq!(stage.gives(name, &args, stops()).await, free, "{name}");
            let told = stage.told();
            let is_announced = told.first().is_some_and(|first| first == "remote.start");
            let begins = row.effect == Effect::Begins && !matches!(row.action, Action::Jog);
            assert_eq!(is_announced, begins, "{name}: {told:?}");

            // A stop by anybody after the message has arrived ends what has not been sent.
            let before = stops();
            panel.stop(Ending::Machine(Stop::Abort)).await.unwrap();
            stage.told();
            let late = stage.gives(name, &args, before).await;
            let wanted = match (&row.action, ends) {
                (Action::ToolChanged, _) => free,
                (_, true) => None,
                (_, false) => Some(Code::Conflict),
            };
            assert_eq!(late, wanted, "{name} after a stop");
            assert_eq!(stage.told().is_empty(), !ends, "{name} after a stop");
            panel.clients.give(&panel.engine, stage.client).await.unwrap();
        }
    });
    std::fs::remove_dir_all(panel.place.folder()).unwrap();
}

#[test]
fn a_person_who_has_left_the_page_stops_the_machine_and_moves_nothing() {
    let stage = Stage::new("idle");
    let panel = stage.panel.clone();
    let viewer = Session { role: Role::Viewer, ..stage.session.clone() };
    let stage = Stage { session: viewer, ..stage };
    run(async {
        for row in ROWS {
            let code = stage.gives(row.name, &args(row.name), panel.engine.stops()).await;
            let wanted = if row.role == Role::Viewer { None } else { Some(Code::Role) };
            assert_eq!(code, wanted, "{}", row.name);
        }
    });
    std::fs::remove_dir_all(panel.place.folder()).unwrap();
}
