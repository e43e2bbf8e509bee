//! Dry runs of machines: every line is executed, and nothing outside is touched.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_protocol::{Kind, Link, Reply, Request};
use hal_tests::{
    programs::{programs, root},
    scratch::Scratch,
};
use halcmd::session::dry_run::DryRun;

/// Executes a script as a dry run; its file is called `m.hal`.
fn dry_run(text: &str) -> (Scratch, DryRun) {
    let scratch = Scratch::new("dry-run-names");
    scratch.write("m.hal", text);
    let file = scratch.path().join("m.hal").display().to_string();
    let dry_run = DryRun::with_plugins(&[file], None, vec![programs().to_owned()]).unwrap();
    (scratch, dry_run)
}

/// Returns the refusals, without the folder.
fn refusals(scratch: &Scratch, dry_run: &DryRun) -> Vec<String> {
    let folder = format!("{}/", scratch.path().display());
    let said = dry_run.result().refusals.iter().map(|r| format!("{}: {}", r.at, r.error.whole()));
    said.map(|text| text.replace(&folder, "")).collect()
}

#[test]
fn the_printer_is_made_whole() {
    let ini = root().join("configs/printer/printer.ini").display().to_string();
    let mut dry_run = DryRun::with_plugins(&[ini], None, vec![programs().to_owned()]).unwrap();
    assert_eq!(dry_run.result().refusals, []);
    assert_eq!(dry_run.result().notices, []);
    let list = Request::List { kind: Kind::Signals, patterns: Vec::new(), ty: None };
    let Reply::Signals(signals) = dry_run.engine().call(list).unwrap() else { panic!() };
    assert_eq!(signals.len(), 27);
    let list = Request::List { kind: Kind::Threads, patterns: Vec::new(), ty: None };
    let Reply::Threads(threads) = dry_run.engine().call(list).unwrap() else { panic!() };
    let functs: Vec<usize> = threads.iter().map(|t| t.functs.len()).collect();
    assert_eq!(functs, [4, 3]);
}

#[test]
fn every_line_is_carried_out_and_refusals_are_kept() {
    let text = "loadrt and2\n\
                setp and2.0.in9 1\n\
                source more.hal\n\
                save all saved.txt\n\
                loadrt threads name1=t period1=1000000\n\
                addf and2.0 t\n\
                start\n\
                record out.vcd\n\
                run 1s\n\
                loadusr -w touch started\n\
                net a and2.0.out\n\
                shutdown\n\
                nonsense\n";
    let scratch = Scratch::new("dry-run-lines");
    scratch.write("m.hal", text);
    scratch.write("more.hal", "setp and2.0.in0 2\nloadrt and2\nnewsig b bit\n");
    scratch.write("m.ini", "[HAL]\nHALFILE = m.hal\nHALFILE = none.hal\n[EMCIO]\nA = 1\n");
    let files = [scratch.path().join("m.ini").display().to_string()];
    let mut dry_run = DryRun::with_plugins(&files, None, vec![programs().to_owned()]).unwrap();
    let said = refusals(&scratch, &dry_run);
    let want = [
        "m.hal:2: parameter or pin 'and2.0.in9': not found; did you mean and2.0.in0?",
        "more.hal:1: pin 'and2.0.in0': invalid argument; ",
        "more.hal:2: and2: already exists",
        "m.hal:13: Unknown command 'nonsense'",
        "m.ini:3: cannot find 'none.hal'; looked in ",
    ];
    assert_eq!(said.len(), want.len(), "{said:#?}");
    for (said, want) in said.iter().zip(want) {
        assert!(said.starts_with(want), "{said}");
    }
    for file in ["saved.txt", "out.vcd", "started"] {
        assert!(!scratch.path().join(file).exists(), "{file} was made");
    }
    let list = Request::List { kind: Kind::Signals, patterns: Vec::new(), ty: None };
    let Reply::Signals(signals) = dry_run.engine().call(list).unwrap() else { panic!() };
    assert_eq!(signals.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
}

#[test]
fn names_of_programs_and_missing_components_are_unknown_not_wrong() {
    let (scratch, dry_run) = dry_run(
        "loadrt and2\n\
         loadrt no_such_card names=card.0\n\
         loadusr -Wn panel gladevcp -c other panel.xml\n\
         loadusr -W shuttlexpress /dev/hidraw0\n\
         net a panel.button => and2.0.in0\n\
         net b shuttlexpress.0.spring-wheel-f\n\
         sets b 1\n\
         net a => card.0.lamp other.lamp\n\
         setp no-such-card.0.scale 5\n\
         linkps shuttlexpress.0.button-0 a\n\
         net c pane.button\n\
         sets d 1\n\
         loadusr -W hal_manualtoolchange\n\
         net e hal_manualtoolchange.changed => and2.0.in1\n\
         net e hal_manualtoolchange.chang\n",
    );
    let said = refusals(&scratch, &dry_run);
    let want = [
        "m.hal:2: no_such_card: no plugin library offers this component",
        "m.hal:11: Pin 'pane.button' does not exist",
        "m.hal:12: signal 'd': not found",
        "m.hal:15: Pin 'hal_manualtoolchange.chang' does not exist; \
         did you mean hal_manualtoolchange.change?",
    ];
    assert_eq!(said.len(), want.len(), "{said:#?}");
    for (said, want) in said.iter().zip(want) {
        assert!(said.starts_with(want), "{said}");
    }
    let unknown: Vec<&String> = dry_run.result().unknown.signals.iter().collect();
    assert_eq!(unknown, ["a", "b"]);
}
