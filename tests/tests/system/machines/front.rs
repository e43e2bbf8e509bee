//! The front command `ferrule`: the demonstration, a machine with its panel, the doctor, the report.
#![expect(clippy::unwrap_used, reason = "tests")]

use flate2::read::GzDecoder;
use hal_golden::check;
use hal_tests::{
    programs::root,
    scratch::{Output, Running, Scratch, until},
    terminal::Terminal,
};
use rustix::process::Signal;
use std::{collections::BTreeMap, fs, io::Read as _, path::Path};

fn ferrule(scratch: &Scratch, words: &[&str]) -> Output {
    scratch.run(scratch.command(&[], "ferrule").args(words))
}

fn refused(scratch: &Scratch, words: &[&str], why: &str) {
    let output = ferrule(scratch, words);
    assert_eq!((output.stderr.as_str(), output.status), (why, Some(1)), "{words:?}");
}

/// Returns a folder with the machine of the demonstration.
fn with_demo(name: &str) -> Scratch {
    let scratch = Scratch::new(name);
    let output = ferrule(&scratch, &["demo"]);
    assert_eq!(output.status, Some(0), "{output:?}");
    scratch
}

#[test]
fn the_demonstration_cuts_its_part_without_a_terminal() {
    let scratch = Scratch::new("demo");
    let output = ferrule(&scratch, &["demo"]);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    let (before, here) = output.stdout.split_once("machine's time, and ").unwrap();
    let said = format!("{before}machine's time, and N{}", &here[here.find(' ').unwrap()..]);
    check(&root().join("tests/machines/ferrule.demo"), &said);
    let picture = fs::read(scratch.path().join("ferrule-demo/pedal.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG") && picture.len() > 2000, "{} bytes", picture.len());

    // A file that a person has changed stays; the part is cut again.
    scratch.write("ferrule-demo/programs/pedal.ngc", "G21 G0 X10\nM2\n");
    let again = ferrule(&scratch, &["demo", "--cut-only"]);
    assert_eq!(again.status, Some(0), "{again:?}");
    assert_ne!(again.stdout, output.stdout);
    assert_eq!(scratch.read("ferrule-demo/programs/pedal.ngc"), "G21 G0 X10\nM2\n");

    // A folder of somebody else's stays as it is.
    fs::create_dir(scratch.path().join("mine")).unwrap();
    scratch.write("mine/printer.ini", "[EMC]\n");
    let why = "ferrule: mine/printer.ini: is there already, and is not the demonstration's: choose another --folder\n";
    refused(&scratch, &["demo", "--folder", "mine"], why);
    assert_eq!(fs::read_dir(scratch.path().join("mine")).unwrap().count(), 1);

    // A program that fails ends with its reason.
    scratch.write("ferrule-demo/programs/pedal.ngc", "G1 X1000 F500\nM2\n");
    let output = ferrule(&scratch, &["demo"]);
    assert_eq!(output.status, Some(1));
    assert!(
        output.stderr.contains("halrun has ended") && output.stderr.contains("pedal.ngc"),
        "{}",
        output.stderr
    );
}

/// Starts the machine of the demonstration, and waits until its panel is there.
fn started(scratch: &Scratch, words: &[&str]) -> Running {
    let words = [&["start", "--virtual", "ferrule-demo/demo.ini"], words].concat();
    let running = scratch.start(scratch.command(&[], "ferrule").args(words));
    let running = running.lasting("ferrule");
    until("the address of the panel", || running.said().0.contains("the panel:"));
    running
}

#[test]
fn a_start_has_the_panel_and_ends_with_the_machine() {
    let scratch = with_demo("front");
    type Stop = fn(&Scratch, &Running);
    let stops: [(&str, Stop); 3] = [
        ("ferrule stop", |scratch, _| assert_eq!(ferrule(scratch, &["stop"]).status, Some(0))),
        ("SIGTERM", |_, running| running.signal(Signal::TERM)),
        ("SIGINT", |_, running| running.signal(Signal::INT)),
    ];
    for (what, stop) in stops {
        let mut running = started(&scratch, &["--listen", "127.0.0.1:0"]);
        let kept = scratch.read("ferrule-demo/.ferrule/demo.ini/000001");
        assert_eq!(kept, scratch.read("ferrule-demo/demo.ini"));
        // Off a terminal the token is not shown: the file that has it is its user's alone.
        let (out, _) = running.said();
        let (_, file) = out.split_once("its address is in ").unwrap();
        let file = Path::new(file.lines().next().unwrap());
        let address = fs::read_to_string(file).unwrap();
        assert!(address.starts_with("http://127.0.0.1:") && address.contains("/#token="));
        assert!(!out.contains("token="), "{out}");
        assert!(ferrule(&scratch, &["status"]).stdout.contains("virtual"));
        let why = "ferrule: instance 'default' runs already: 'ferrule stop' ends it, '--instance NAME' starts another beside it\n";
        refused(&scratch, &["start", "--virtual", "ferrule-demo/demo.ini"], why);
        stop(&scratch, &running);
        let status = running.ended().unwrap();
        assert_eq!(status.code(), Some(0), "{what}: {:?}", running.said());
        assert!(!file.exists(), "{what}: the panel has not ended");
        let left: Vec<_> = scratch.left().into_iter().filter(|f| f.ends_with(".sock")).collect();
        assert!(left.is_empty(), "{what}: {left:?}");
    }
}

#[test]
fn a_panel_that_cannot_be_ends_the_machine() {
    let scratch = with_demo("nopanel");
    let output = ferrule(
        &scratch,
        &["start", "--virtual", "--listen", "192.0.2.1:7776", "ferrule-demo/demo.ini"],
    );
    assert_eq!(output.status, Some(1));
    assert!(output.stderr.contains("192.0.2.1:7776 is a network address"), "{}", output.stderr);
    assert!(
        output.stderr.contains("ferrule: halpanel has ended (exit status: 1)"),
        "{}",
        output.stderr
    );
    assert_eq!(scratch.halcmd(&["status"]).status, Some(1), "the machine still runs");
}

#[test]
fn a_start_says_what_is_wrong_before_anything_runs() {
    let scratch = Scratch::new("wrong");
    scratch.write("bad.ini", "[EMC\n");
    scratch.write("panel.ini", "[DISPLAY]\nDISPLAY = halpanel\n[EMC]\nMACHINE = x\n");
    for (words, why) in [
        (
            &["start", "none.ini"][..],
            "ferrule: none.ini: there is no such file; 'ferrule new' writes a machine, 'ferrule demo' shows one\n",
        ),
        (
            &["start", "panel.ini", "--role", "viewer"],
            "ferrule: --role: the INI file starts the panel itself ([DISPLAY]DISPLAY = halpanel); write it behind halpanel there\n",
        ),
        (
            &["start", "panel.ini", "--instance", "no/such"],
            "ferrule: instance name 'no/such' is not usable: letters, digits, '-' and '_', at most 32\n",
        ),
    ] {
        refused(&scratch, words, why);
    }
    let output = ferrule(&scratch, &["start", "bad.ini"]);
    assert!(output.status == Some(1) && output.stderr.contains("bad.ini:1"), "{output:?}");
    assert_eq!(scratch.left(), Vec::<String>::new());
}

#[test]
fn on_a_terminal_the_demonstration_goes_on_with_the_panel() {
    let scratch = Scratch::new("terminal");
    let mut terminal = Terminal::start(&scratch, "ferrule", &["demo", "--no-browser"]);
    let shown = terminal.until("/#token=");
    assert!(shown.contains("axis   from mm"), "{shown}");
    terminal.until("ends the machine");
    rustix::process::kill_process(
        rustix::process::Pid::from_raw(i32::try_from(terminal.pid()).unwrap()).unwrap(),
        Signal::INT,
    )
    .unwrap();
    let (status, is_sane, rest) = terminal.end();
    assert_eq!((status, is_sane), (Some(0), true), "{rest}");
}

#[test]
fn words_for_another_program_reach_it() {
    let scratch = Scratch::new("words");
    let help = ferrule(&scratch, &["new", "--help"]);
    assert!(help.stdout.starts_with("Usage: halsetup") && help.status == Some(0), "{help:?}");
    let output = ferrule(&scratch, &["new", "none.setup"]);
    assert!(output.stderr.starts_with("halsetup: none.setup"), "{output:?}");
    let output = ferrule(&scratch, &["status", "instance"]);
    assert_eq!(output.status, Some(1), "{output:?}");
    assert_eq!(ferrule(&scratch, &["stop", "--instance", "none"]).status, Some(0));
}

/// Files of a system that lacks everything, and of one that has it.
const SYSTEMS: [(&str, &[(&str, &str)]); 2] = [
    (
        "poor",
        &[
            ("proc/version", "Linux version 6.1.0-13-amd64 (x) #1 SMP PREEMPT_DYNAMIC"),
            ("proc/ioports", "  0378-037a : parport0\n"),
            ("proc/modules", "lp 20480 0 - Live 0x0\n"),
            ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n"),
            ("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance\n"),
            ("sys/devices/system/cpu/isolated", "\n"),
            ("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n"),
            ("sys/class/net/enp3s0/device/vendor", "0x8086\n"),
            ("sys/class/net/lo/mtu", "65536\n"),
        ],
    ),
    (
        "rich",
        &[
            ("proc/version", "Linux version 6.1.0-13-rt-amd64 (x) #1 SMP PREEMPT_RT"),
            ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n"),
            ("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance\n"),
            ("sys/devices/system/cpu/isolated", "1\n"),
            ("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n"),
            ("dev/cpu_dma_latency", ""),
        ],
    ),
];

#[test]
fn the_doctor_finds_what_a_computer_lacks() {
    for (name, files) in SYSTEMS {
        let scratch = Scratch::new(name);
        for (path, text) in files {
            let path = scratch.path().join("root").join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let output = ferrule(&scratch, &["doctor", "--root", "root"]);
        // Permissions are those of the user who tests.
        let said: Vec<&str> =
            output.stdout.lines().filter(|l| !l.contains("permissions")).collect();
        let about = |subject: &str| said.iter().filter(|l| l.contains(subject)).count();
        let is_poor = name == "poor";
        assert_eq!(about("better"), if is_poor { 5 } else { 1 }, "{output:?}");
        assert_eq!(about("hpet is slow"), usize::from(is_poor));
        assert_eq!(about("powersave"), usize::from(is_poor));
        assert_eq!(about("isolcpus=1"), usize::from(is_poor));
        assert_eq!(about("sudo modprobe -r lp"), usize::from(is_poor));
        assert_eq!(about("enp3s0"), usize::from(is_poor), "{output:?}");
        assert_eq!(about("realtime kernel"), 1);
        if is_poor {
            assert_eq!(output.status, Some(1));
            let fix = ferrule(&scratch, &["doctor", "--fix", "--root", "root"]);
            let why = "ferrule: --fix asks a person at a terminal: type the lines yourself\n";
            assert_eq!((fix.stderr.as_str(), fix.status), (why, Some(1)));
        }
    }
}

#[test]
fn a_fix_is_asked_for_and_only_then_run() {
    let scratch = Scratch::new("fix");
    for (path, text) in SYSTEMS[0].1 {
        let path = scratch.path().join("root").join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    let mut terminal = Terminal::start(&scratch, "ferrule", &["doctor", "--fix", "--root", "root"]);
    let mut asked = 0;
    let shown = terminal.until("run this? [y/N] ");
    assert!(shown.contains("sudo "), "{shown}");
    loop {
        asked += 1;
        terminal.keys("n\n");
        if asked == questions(&shown) {
            break;
        }
        terminal.until("run this? [y/N] ");
    }
    let (status, is_sane, rest) = terminal.end();
    assert_eq!((status, is_sane), (Some(1), true), "{rest}");
    assert!(!rest.contains("done"), "{rest}");
}

/// Returns how many lines the doctor would run.
fn questions(shown: &str) -> usize {
    shown.lines().filter(|line| line.trim_start().starts_with("do: ")).count()
}

/// Returns the files of an archive.
fn unpacked(path: &Path) -> BTreeMap<String, String> {
    let mut archive = tar::Archive::new(GzDecoder::new(fs::File::open(path).unwrap()));
    let entries = archive.entries().unwrap().map(|entry| {
        let mut entry = entry.unwrap();
        let name = entry.path().unwrap().display().to_string();
        let mut text = String::new();
        entry.read_to_string(&mut text).unwrap();
        (name, text)
    });
    entries.collect()
}

#[test]
fn a_report_has_what_is_listed_and_nothing_private() {
    let scratch = with_demo("report");
    scratch.write("ferrule-demo/custom_postgui.hal", "# by workshop-user at 10.20.30.40\n");
    scratch.write("ferrule-demo/net.ini", "WIFI_PASSWORD = hunter2\nMACHINE = x\n");
    scratch.write("ferrule-demo/photo.jpg", "no text");
    let why = "ferrule: ferrule report asks a person at a terminal: --yes writes it without\n";
    refused(&scratch, &["report", "ferrule-demo"], why);
    let running = started(&scratch, &["--listen", "127.0.0.1:0"]);
    let mut command = scratch.command(&[], "ferrule");
    command
        .args(["report", "--yes", "-o", "r.tar.gz", "ferrule-demo/demo.ini"])
        .env("USER", "workshop-user");
    let output = scratch.run(&mut command);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    let files = unpacked(&scratch.path().join("r.tar.gz"));
    for name in files.keys() {
        let name = name.strip_prefix("ferrule-report/").unwrap();
        assert!(output.stdout.contains(name), "{name} is not listed: {}", output.stdout);
    }
    let text = |name: &str| {
        files
            .get(&format!("ferrule-report/{name}"))
            .unwrap_or_else(|| panic!("{name}: {:?}", files.keys()))
    };
    assert!(text("status.txt").contains("virtual"));
    assert!(text("show.txt").contains("axis.0.motor-pos-cmd"));
    assert!(text("versions.txt").contains("halrun ") && text("computer.txt").contains("kernel"));
    assert!(text("machine/printer.hal").contains("loadrt"));
    assert_eq!(text("machine/custom_postgui.hal"), "# by USER at ADDRESS\n");
    assert_eq!(text("machine/net.ini"), "WIFI_PASSWORD = (left out)\nMACHINE = x\n");
    assert!(!files.keys().any(|name| name.contains("photo")));
    running.signal(Signal::TERM);
    assert_eq!(running.wait().status, Some(0));
}

#[test]
fn the_manual_is_written_listed_and_searched() {
    let scratch = Scratch::new("manual");
    let listed = ferrule(&scratch, &["docs"]);
    assert!(listed.stdout.contains("\n  Hardware\n"), "{listed:?}");
    assert!(scratch.files().is_empty(), "without a terminal nothing is written");
    let found = ferrule(&scratch, &["docs", "parallel", "breakout board"]);
    assert!(found.stdout.starts_with("Hardware · Parallel port\n"), "{found:?}");
    let why = "ferrule: no section of the manual has 'xyzzy': fewer words find more, 'ferrule docs' lists the chapters\n";
    refused(&scratch, &["docs", "xyzzy"], why);
    let written = ferrule(&scratch, &["docs", "-o", "manual"]);
    assert_eq!(
        (written.stdout.as_str(), written.status),
        ("The manual is manual/index.html\n", Some(0))
    );
    let page = scratch.read("manual/index.html");
    assert!(page.contains("About this manual") && page.contains("href=\"hardware.html\""));
    for (name, _) in hal_docs::FILES {
        assert!(scratch.path().join("manual").join(name).is_file(), "{name}");
    }
    // A folder that cannot be made is named.
    scratch.write("file", "");
    refused(&scratch, &["docs", "-o", "file/in"], "ferrule: file/in: Not a directory\n");
}
