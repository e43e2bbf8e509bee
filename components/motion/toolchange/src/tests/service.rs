//! The service for the worker that controls jobs.

use super::Rig;
use hal_component::{IoControlRef, IoRequest, IoResult};
use std::thread;

fn rig() -> (Rig, IoControlRef) {
    let mut rig = Rig::enabled();
    let io = rig.0.find();
    (rig, io)
}

fn result(rig: &Rig, io: &mut IoControlRef, request: IoRequest) -> Option<&'static str> {
    let id = io.request(request).unwrap();
    rig.cycle();
    let result = io.result().unwrap();
    assert_eq!(result.id, id);
    result.failure
}

#[test]
fn a_tool_is_prepared_and_changed_by_requests() {
    let (rig, mut io) = rig();
    assert_eq!(
        result(&rig, &mut io, IoRequest::Change),
        Some("no tool is prepared: iocontrol.prepare tool=N comes first")
    );
    let prepare = io.request(IoRequest::Prepare { tool: 3, pocket: 7, index: 1 }).unwrap();
    rig.cycle();
    assert_eq!((io.result(), io.state().prepared, io.state().tool), (None, 3, 0));
    rig.set("tool-prepared", true);
    rig.cycle();
    assert_eq!(io.result(), Some(IoResult { id: prepare, failure: None }));
    let change = io.request(IoRequest::Change).unwrap();
    rig.cycle();
    assert_eq!(rig.on(), ["user-enable-out", "tool-change"]);
    rig.set("tool-changed", true);
    rig.cycle();
    assert_eq!(io.result(), Some(IoResult { id: change, failure: None }));
    assert_eq!((io.state().tool, io.state().pocket), (3, 7));
}

#[test]
fn an_estop_takes_effect_at_once_and_ends_what_waits() {
    let (rig, mut io) = rig();
    let on = IoRequest::Coolant { mist: None, flood: Some(true), lube: Some(true) };
    assert_eq!(result(&rig, &mut io, on), None);
    assert!(io.state().flood && io.state().lube && !io.state().mist);
    let prepare = io.request(IoRequest::Prepare { tool: 1, pocket: 1, index: 0 }).unwrap();
    rig.cycle();
    let estop = io.request(IoRequest::Estop).unwrap();
    assert!(io.state().estop.commanded && !io.state().flood && !io.state().lube);
    rig.set("emc-enable-in", false);
    rig.cycle();
    assert_eq!(io.result(), Some(IoResult { id: prepare, failure: Some("e-stop") }));
    assert_eq!(io.result(), Some(IoResult { id: estop, failure: None }));
    assert_eq!(result(&rig, &mut io, on), Some("the machine is in e-stop"));
}

#[test]
fn requests_without_space_for_their_results_are_refused() {
    let (rig, mut io) = rig();
    for _ in 0..crate::service::RESULTS {
        assert!(io.request(IoRequest::Abort).is_some());
    }
    assert_eq!(io.request(IoRequest::Abort), None);
    rig.cycle();
    assert_eq!(io.request(IoRequest::Abort), None);
    assert!(io.result().is_some());
    assert!(io.request(IoRequest::Abort).is_some());
    assert_eq!(io.request(IoRequest::Estop), None);
    assert!(io.state().estop.commanded, "the e-stop itself is never refused");
}

#[test]
fn requests_of_two_threads_have_different_numbers_and_each_has_a_result() {
    let (rig, io) = rig();
    for _ in 0..20 {
        let begin = |half: usize| {
            let mut io = io.clone();
            move || (0..half).map(|_| io.request(IoRequest::Abort).unwrap()).collect::<Vec<_>>()
        };
        let half = crate::service::RESULTS / 2;
        let (one, two) = (thread::spawn(begin(half)), thread::spawn(begin(half)));
        let mut numbers = one.join().unwrap();
        numbers.extend(two.join().unwrap());
        numbers.sort_unstable();
        rig.cycle();
        let mut io = io.clone();
        let results: Vec<u64> = core::iter::from_fn(|| io.result()).map(|r| r.id).collect();
        assert_eq!(results, numbers);
        assert!(results.is_sorted_by(|a, b| a < b) && results.len() == 2 * half);
    }
}
