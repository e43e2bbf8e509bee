//! Sessions of people who look, who work, and whose jobs run, on a clock that is turned.

use super::{IDLE, LIFE, Role, Session, Sessions};
use std::time::Duration;
use tokio::{runtime, time::advance};

/// A second.
const SECOND: Duration = Duration::from_secs(1);

/// Runs a test on a clock that stands still until it is turned.
fn run(test: impl Future<Output = ()>) {
    let runtime = runtime::Builder::new_current_thread().enable_all().start_paused(true).build();
    runtime.unwrap().block_on(test);
}

fn begin(sessions: &Sessions) -> (Session, String) {
    sessions.begin("ana", Role::Operator).unwrap()
}

impl Sessions {
    /// Takes the role that a person loses without input.
    pub(crate) fn forget_input(&self, session: &Session) {
        if let Some(entry) = self.list().get_mut(&session.cookie) {
            entry.session.role = Role::Viewer;
        }
    }
}

#[test]
fn who_gives_no_input_only_looks_until_the_next_sign_in() {
    run(async {
        let sessions = Sessions::default();
        let (ana, key) = begin(&sessions);
        for _ in 0..10 {
            advance(IDLE - SECOND).await;
            sessions.note_input(&ana);
        }
        assert_eq!(sessions.role(&ana), Some(Role::Operator), "input keeps the role");
        advance(IDLE).await;
        assert_eq!(sessions.role(&ana), Some(Role::Operator));
        advance(SECOND).await;
        assert_eq!(sessions.role(&ana), Some(Role::Viewer));
        // Input that comes then brings nothing back, and the page still shows the machine.
        sessions.note_input(&ana);
        sessions.keep(&ana);
        assert_eq!(sessions.role(&ana), Some(Role::Viewer));
        assert_eq!(sessions.find(&ana.cookie, &key).map(|s| s.role), Some(Role::Viewer));
        assert_eq!(sessions.find(&ana.cookie, "wrong"), None);
        let (again, _) = begin(&sessions);
        assert_eq!(sessions.role(&again), Some(Role::Operator));
    });
}

#[test]
fn a_session_that_keeps_a_job_lasts_as_long_as_the_job() {
    run(async {
        let sessions = Sessions::default();
        let ((ana, key), (ida, _)) = (begin(&sessions), begin(&sessions));
        // A job of 20 hours, in which nobody touches anything.
        for _ in 0..20 * 3600 {
            advance(SECOND).await;
            sessions.keep(&ana);
            assert_eq!(sessions.role(&ana), Some(Role::Operator));
        }
        assert_eq!(sessions.role(&ida), None, "who only looked has ended");
        // After it the time without input begins.
        advance(IDLE).await;
        assert_eq!(sessions.role(&ana), Some(Role::Operator));
        advance(SECOND).await;
        assert_eq!(sessions.role(&ana), None, "it is longer than its life, and keeps no job");
        assert_eq!(sessions.find(&ana.cookie, &key), None);
    });
}

#[test]
fn a_session_has_a_longest_life() {
    run(async {
        let sessions = Sessions::default();
        let (ana, key) = begin(&sessions);
        let mut passed = Duration::ZERO;
        while passed + IDLE <= LIFE {
            advance(IDLE).await;
            passed += IDLE;
            sessions.note_input(&ana);
        }
        assert_eq!(sessions.role(&ana), Some(Role::Operator));
        advance(SECOND).await;
        assert_eq!((sessions.role(&ana), sessions.find(&ana.cookie, &key)), (None, None));
    });
}
