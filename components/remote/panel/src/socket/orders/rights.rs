//! The table of rights of the socket: every command, line of G-code and use of the lease by every role, in every state.

use super::{
    super::{Connection, message::LeaseAction},
    tests::{Stage, args},
};
use crate::{
    commands::{Args, ROWS},
    error::Error,
    lease::tests::run,
    session::{Role, Session},
};
use hal_golden::rights::RightsTable;
use hal_protocol::Stop;
use serde_json::json;
use std::{
    path::{Path, PathBuf},
    sync::atomic::Ordering::Relaxed,
};

const ROLES: [(&str, Role); 4] = [
    ("viewer", Role::Viewer),
    ("operator", Role::Operator),
    ("integrator", Role::Integrator),
    ("idle", Role::Operator),
];
const LEASES: [&str; 3] = ["none", "own", "other"];
const STATES: [&str; 4] = ["ready", "forbidden", "stopped", "gone"];

/// Lines of G-code that change more than positions: outputs, tools, files, user codes, parameters and subroutines.
const LINES: &[&str] = &[
    "M3 S100",
    "M6 T1",
    "M62 P0",
    "M64 P0",
    "M66 P0",
    "M68 E0 Q1",
    "M101",
    "(LOGOPEN x)",
    "(PROBEOPEN x)",
    "#5221=1",
    "G10 L2 P1 X0",
    "o<a> call",
];
/// Uses of the lease: what is done, to which client, and whether by force.
const LEASE: &[(&str, LeaseAction, Option<u64>, bool)] = &[
    ("lease take", LeaseAction::Take, None, false),
    ("lease take by force", LeaseAction::Take, None, true),
    ("lease give", LeaseAction::Give, None, false),
    ("lease hand", LeaseAction::Hand, Some(99), false),
];

pub(crate) fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tests/rights").join(name)
}

fn code(end: &Result<(), Error>) -> String {
    let code = |e: &Error| json!(e.code).as_str().unwrap_or_default().to_owned();
    end.as_ref().err().map_or_else(|| "ok".to_owned(), code)
}

impl Stage {
    /// Returns a stage of these circumstances.
    async fn of(who: usize, lease: usize, state: usize) -> Self {
        let (name, role) = ROLES[who];
        let mut stage = Self::new(&format!("rights-{who}-{lease}-{state}"));
        let panel = stage.panel.clone();
        let (session, _) = panel.sessions.begin("ana", role).unwrap();
        let client = panel.clients.enter(&session);
        if LEASES[lease] == "own" && role != Role::Viewer {
            panel.clients.take(&panel.engine, client, &session, false).await.unwrap();
        }
        if LEASES[lease] == "other" {
            let holder = &stage.session;
            panel.clients.take(&panel.engine, stage.client, holder, false).await.unwrap();
        }
        if name == "idle" {
            panel.sessions.forget_input(&session);
        }
        (stage.session, stage.client) = (session, client);
        panel.heart.allowed.store(STATES[state] != "forbidden", Relaxed);
        stage
    }

    /// Returns what comes of a command in a state.
    async fn tries(&self, state: usize, name: &str, args: &Args) -> String {
        let before = self.panel.engine.stops();
        self.enter(state).await;
        code(&self.order(before).command(1, name, args).await.map(drop))
    }

    async fn enter(&self, state: usize) {
        match STATES[state] {
            "stopped" => {
                let stop = crate::engine::Ending::Machine(Stop::Abort);
                self.panel.stop(stop).await.map(drop).unwrap();
            }
            "gone" => self.panel.engine.end(),
            _ => {}
        }
    }
}

#[test]
fn every_command_has_the_rights_of_its_rule() {
    let mut table = RightsTable::of(&file("commands.rules"));
    run(async {
        for (who, lease, state) in all() {
            let circumstances = [ROLES[who].0, LEASES[lease], STATES[state]];
            let stage = Stage::of(who, lease, state).await;
            for row in ROWS {
                let end = stage.tries(state, row.name, &args(row.name)).await;
                table.row(row.name, &circumstances, &end);
            }
            for line in LINES {
                let given = serde_json::from_value(json!({ "text": line })).unwrap();
                let end = stage.tries(state, "mdi", &given).await;
                table.row(&format!("mdi {line}"), &circumstances, &end);
            }
            std::fs::remove_dir_all(stage.panel.place.folder()).unwrap();
            for (name, action, to, force) in LEASE {
                // Each changes who has it.
                let stage = Stage::of(who, lease, state).await;
                stage.enter(state).await;
                let end = stage.order(stage.panel.engine.stops()).lease(*action, *to, *force).await;
                table.row(name, &circumstances, &code(&end));
                std::fs::remove_dir_all(stage.panel.place.folder()).unwrap();
            }
            let stage = Stage::of(who, lease, state).await;
            let role = stage.panel.sessions.role(&stage.session).unwrap();
            let session = Session { role, ..stage.session.clone() };
            let mut connection = Connection::new(&stage.panel, session, stage.client);
            let wanted = serde_json::from_value(json!({ "names": ["a"], "seconds": 1 })).unwrap();
            table.row("scope", &circumstances, &code(&connection.start_scope(1, Some(wanted))));
            drop(connection);
            std::fs::remove_dir_all(stage.panel.place.folder()).unwrap();
        }
    });
    table.finish(&file("commands.md"));
}

fn all() -> impl Iterator<Item = (usize, usize, usize)> {
    let (roles, leases, states) = (ROLES.len(), LEASES.len(), STATES.len());
    // A viewer has no lease.
    let possible = |(who, lease, _): &(usize, usize, usize)| {
        ROLES[*who].0 != "viewer" || LEASES[*lease] != "own"
    };
    (0..roles * leases * states)
        .map(move |n| (n / (leases * states), n / states % leases, n % states))
        .filter(possible)
}
