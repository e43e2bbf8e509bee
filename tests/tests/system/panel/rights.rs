//! The table of rights of the engine's socket: every request by a client that speaks for people elsewhere, and by another user.

use super::printer::Printer;
use hal_golden::rights::RightsTable;
use hal_protocol::{
    Client, Direction, Edit, FlightSpec, Kind, LATEST, Link as _, Lock, NOT_FROM_AFAR, Request,
    SampleSpec, Type,
};
use hal_tests::{
    programs::root,
    user::{as_user, is_root},
};

/// A user without rights: `nobody`.
const NOBODY: u32 = 65_534;

/// Defines an example of every request, and the name of each: a request without an example does not compile.
macro_rules! examples {
    ($($name:ident: $example:expr;)*) => {
        fn name(request: &Request) -> &'static str {
            match request {
                $(Request::$name { .. } => stringify!($name),)*
            }
        }

        fn examples() -> Vec<Request> {
            vec![$($example),*]
        }
    };
}

fn text(text: &str) -> String {
    text.to_owned()
}

examples! {
    Hello: Request::Hello { protocol: LATEST, name: String::new(), pid: 1 };
    Join: Request::Join { name: text("own"), poll_ns: 0 };
    NewPin: Request::NewPin { name: text("own.a"), ty: Type::Bit, direction: Direction::Out };
    Ready: Request::Ready;
    Unready: Request::Unready;
    Leave: Request::Leave;
    SharePins: Request::SharePins { pins: 1 };
    Sleep: Request::Sleep { ns: 1 };
    Poll: Request::Poll { writes: Vec::new() };
    Attach: Request::Attach { name: text("sampler.0"), count: None };
    NewStream: Request::NewStream { name: text("own"), depth: 2, types: vec![Type::Bit] };
    Sample: Request::Sample(SampleSpec { names: vec![text("no.such.pin")], ..SampleSpec::default() });
    SampleState: Request::SampleState { id: 0 };
    EndSample: Request::EndSample { id: 0 };
    AtEnd: Request::AtEnd { commands: Vec::new() };
    SpeakFromAfar: Request::SpeakFromAfar;
    MapSnapshot: Request::MapSnapshot { name: text("motion.status") };
    Run: Request::Run { ns: 1 };
    Ticket: Request::Ticket { id: 0, wait: false };
    Idle: Request::Idle { ms: 0, flow: false };
    Await: Request::Await { ms: 0, pid: 0 };
    Load: Request::Load { module: text("and2"), args: Vec::new() };
    LoadForeign: Request::LoadForeign { module: text("a"), args: Vec::new(), prefix: String::new() };
    Unload: Request::Unload { name: text("stepgen") };
    UnloadAll: Request::UnloadAll;
    NewSignal: Request::NewSignal { name: text("own-signal"), ty: Type::Bit };
    DeleteSignal: Request::DeleteSignal { name: None };
    Net: Request::Net { signal: text("own-signal"), pins: vec![text("stepgen.0.enable")] };
    Link: Request::Link { pin: text("stepgen.0.enable"), signal: text("own-signal") };
    Unlink: Request::Unlink { pin: text("stepgen.0.enable") };
    Set: Request::Set { name: text("stepgen.0.position-cmd"), value: text("5") };
    SetSignal: Request::SetSignal { name: text("xpos-cmd"), value: text("5") };
    AddFunct: Request::AddFunct { funct: text("viagpio.read"), thread: text("servo-thread"), position: -1, init: false };
    RemoveFunct: Request::RemoveFunct { funct: text("motion-controller"), thread: None };
    Start: Request::Start;
    Alias: Request::Alias { param: false, name: text("motion.enable"), alias: text("own-name") };
    Unalias: Request::Unalias { param: false, name: text("own-name") };
    SetLock: Request::SetLock { level: Lock::RUN };
    ClearLock: Request::ClearLock { bits: Lock::RUN };
    Get: Request::Get { name: text("motion.enable") };
    GetSignal: Request::GetSignal { name: text("xpos-cmd") };
    List: Request::List { kind: Kind::Pins, patterns: Vec::new(), ty: None };
    Status: Request::Status;
    Order: Request::Order;
    Component: Request::Component { name: text("stepgen") };
    FlightState: Request::FlightState;
    Snapshot: Request::Snapshot { name: text("motion.status") };
    Check: Request::Check;
    Stop: Request::Stop;
    Apply: Request::Apply {
        files: vec![text("a.hal")],
        edits: vec![Edit {
            file: 0,
            line: 1,
            request: Request::Set { name: text("stepgen.0.position-cmd"), value: text("5") },
        }],
        dry: false,
    };
    Timing: Request::Timing { thread: None, on: true };
    MessageLevel: Request::MessageLevel { level: 0 };
    Command: Request::Command { name: text("motion.abort"), args: Vec::new() };
    Adopt: Request::Adopt { pid: 2, program: text("a") };
    EndProgram: Request::EndProgram { name: None };
    Record: Request::Record { path: text("a.vcd"), patterns: Vec::new() };
    EndRecord: Request::EndRecord;
    Flight: Request::Flight(FlightSpec::default());
    EndFlight: Request::EndFlight;
    SaveFlight: Request::SaveFlight { path: text("a.vcd"), last: false };
    // The last one ends the machine.
    Shutdown: Request::Shutdown;
}

#[test]
fn every_request_of_the_engine_has_the_rights_of_its_rule() {
    let folder = root().join("tests/rights");
    let mut table = RightsTable::of(&folder.join("engine.rules"));
    let printer = Printer::start("viewer");
    let place = printer.scratch.place("default");
    if is_root() {
        as_user(NOBODY, || {
            for request in examples() {
                assert!(Client::connect(&place, "").is_err(), "{}", name(&request));
            }
        });
    }
    let save = || ["save net", "save thread", "save comp"].map(|line| printer.halcmd(line));
    let before = save();
    for request in examples() {
        // Of another user, the socket takes no request at all.
        table.row(name(&request), &["another-user"], "no connection");
        let ends = request == Request::Shutdown;
        let mut client = Client::connect_from_afar(&place).unwrap();
        let name = name(&request);
        let end = match client.call(request) {
            Err(e) if e.code == NOT_FROM_AFAR => "not from afar",
            Ok(_) | Err(_) => "served",
        };
        table.row(name, &["from-afar"], end);
        if name == "NewSignal" {
            printer.halcmd("delsig own-signal");
        }
        assert!(ends || save() == before, "{name} has changed the machine");
    }
    table.finish(&folder.join("engine.md"));
}
