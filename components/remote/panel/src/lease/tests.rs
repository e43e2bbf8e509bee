//! Operators who take the lease, and clients who are handed it.

use super::{Beating, Clients, Code, Engine, Instant, Reply, Request, Role, SILENCE, Session};
use hal_protocol::Answer;
use tokio::runtime;

/// Returns an engine that gives a lease to everybody who asks.
pub(crate) fn engine() -> Engine {
    let mut last = 0;
    Engine::that(move |request| {
        let Request::Command { name, .. } = request else { return Ok(Reply::Done) };
        last += u64::from(name == "remote.take");
        Ok(Reply::Answer(Answer {
            lines: vec![format!("lease={last}")],
            ticket: None,
            awaited: false,
        }))
    })
}

pub(crate) fn session(user: &str) -> Session {
    Session { cookie: String::new(), user: user.to_owned(), role: Role::Operator }
}

/// Runs a future to its end.
pub(crate) fn run<T>(work: impl Future<Output = T>) -> T {
    runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .enable_all()
        .build()
        .unwrap()
        .block_on(work)
}

impl Clients {
    /// Lets the holder be silent for longer than is permitted.
    pub(crate) fn silence(&self) {
        self.with(|table| {
            if let Some(holder) = &mut table.holder {
                let long = SILENCE + SILENCE;
                holder.answered = Instant::now().checked_sub(long).unwrap();
            }
        });
    }
}

#[test]
fn a_user_of_teleoperation_is_handed_no_lease() {
    let (clients, engine) = (Clients::default(), engine());
    run(async {
        let [eva, ida] = [session("eva"), session("ida")].map(|s| clients.enter(&s));
        let ana = clients.enter_without_page(&session("ana"));
        clients.take(&engine, eva, &session("eva"), false).await.unwrap();
        let why = clients.hand(&engine, eva, ana).await.unwrap_err();
        assert_eq!((why.code, clients.number(eva)), (Code::Conflict, Some(1)), "{why:?}");
        clients.hand(&engine, eva, ida).await.unwrap();
        assert_eq!((clients.number(eva), clients.number(ida)), (None, Some(2)));
    });
}

#[test]
fn an_operator_takes_the_lease_of_who_is_silent_alone() {
    let (clients, engine) = (Clients::default(), engine());
    run(async {
        let [eva, ida] = [session("eva"), session("ida")].map(|s| clients.enter(&s));
        clients.take(&engine, eva, &session("eva"), false).await.unwrap();
        let of = session("ida");
        let take = || clients.take(&engine, ida, &of, true);
        assert_eq!(take().await.unwrap_err().code, Code::Conflict);
        clients.silence();
        assert!(clients.answered(eva));
        assert_eq!(take().await.unwrap_err().code, Code::Conflict);
        clients.silence();
        take().await.unwrap();
        assert_eq!(clients.number(ida), Some(2));
    });
}

#[test]
fn a_lease_that_the_servo_thread_does_not_have_is_lost_although_it_never_was_confirmed() {
    let (clients, panel) = (Clients::default(), session("eva"));
    // The plugin's answers: leases 1, 2, … that begin at a pulse of 1000 ms.
    let mut last = 0;
    let engine = Engine::that(move |request| {
        let Request::Command { name, .. } = request else { return Ok(Reply::Done) };
        last += u64::from(name == "remote.take");
        let beat = "pulse=1000 permit=FALSE beat=0".to_owned();
        let line = if name == "remote.beat" { beat } else { format!("lease={last}") };
        Ok(Reply::Answer(Answer { lines: vec![line], ticket: None, awaited: false }))
    });
    let eva = clients.enter(&panel);
    run(async {
        for (seen, wanted) in [
            // An exchange before the lease, and one that may be as old.
            (&[(0, 900)][..], true),
            (&[(0, 1020)], true),
            // This program stood still until the lease had ended.
            (&[(0, 1021)], false),
            (&[(0, 60_000)], false),
            // Somebody else has it.
            (&[(9, 1021)], false),
            (&[(0, 1000), (2, 1004), (2, 60_000)], true),
            (&[(2, 1004), (0, 1008)], false),
        ] {
            clients.take(&engine, eva, &panel, false).await.unwrap();
            let number = u32::try_from(clients.number(eva).unwrap()).unwrap();
            let mut confirmed = None;
            for (lease, pulse) in seen {
                let lease = if *lease == 2 { number } else { *lease };
                clients.check(eva, Beating { lease, pulse: *pulse }, &mut confirmed);
            }
            assert_eq!(clients.number(eva).is_some(), wanted, "{seen:?}");
            clients.give(&engine, eva).await.unwrap();
        }
    });
}
