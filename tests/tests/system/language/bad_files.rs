//! Files that no editor writes: endless, huge, sourced without end, with thousands of loads, with a byte order mark. `halrun` and `halcmd check`
//! end with a message or take the file.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::scratch::Scratch;
use std::fmt::Write;

/// Use of a file.
enum Use {
    /// `halrun -f FILE` and `halcmd check FILE`.
    Run,
    /// A script sources it.
    Source,
}

/// File with the statuses of `halrun -f` and `halcmd check`, and a text that both must print; none if it is empty.
struct Row {
    name: &'static str,
    content: fn() -> String,
    way: Use,
    statuses: [i32; 2],
    says: &'static str,
}

const ROWS: &[Row] = &[
    Row {
        name: "mark.hal",
        content: || "\u{feff}loadrt threads\nbogus\n".to_owned(),
        way: Use::Run,
        statuses: [1, 2],
        says: "mark.hal:2: ",
    },
    Row {
        name: "mark.ini",
        content: || "\u{feff}[HAL]\nHALFILE = main.hal\n".to_owned(),
        way: Use::Run,
        statuses: [0, 1],
        says: "",
    },
    Row {
        name: "sections.ini",
        content: || {
            let mut text = String::new();
            for n in 0..100_000 {
                write!(text, "[S{n}]\nA = {n}\n").unwrap();
            }
            text + "[HAL]\nHALFILE = main.hal\n"
        },
        way: Use::Run,
        statuses: [0, 1],
        says: "",
    },
    Row {
        name: "halfiles.ini",
        content: || "[HAL]\n".to_owned() + &"HALFILE = main.hal\n".repeat(20_000),
        way: Use::Run,
        statuses: [0, 1],
        says: "",
    },
    Row {
        name: "long.hal",
        content: || format!("# short\nloadrt {}\nbogus\n", "x".repeat(5_000_000)),
        way: Use::Run,
        statuses: [1, 2],
        says: "long.hal:2: ",
    },
    Row {
        name: "after.hal",
        content: || format!("# {}\nbogus\n", "x".repeat(1021)),
        way: Use::Run,
        statuses: [1, 2],
        says: "after.hal:2: ",
    },
    Row {
        name: "itself.hal",
        content: || "source itself.hal\n".to_owned(),
        way: Use::Run,
        statuses: [1, 2],
        says: "sourced within itself",
    },
    Row {
        name: "/dev/zero",
        content: String::new,
        way: Use::Source,
        statuses: [1, 2],
        says: "it is a device, not a file",
    },
    Row {
        name: "pipe",
        content: String::new,
        way: Use::Source,
        statuses: [1, 2],
        says: "it is a pipe, not a file",
    },
    Row {
        name: "twice-1.hal",
        content: String::new,
        way: Use::Source,
        statuses: [1, 2],
        says: "more than 10000 files are sourced",
    },
];

#[test]
fn bad_files_are_refused_or_taken_and_never_endless() {
    let scratch = Scratch::new("bad-files");
    scratch.write("main.hal", "# nothing\n");
    for n in 1..30 {
        let next = format!("source twice-{}.hal\n", n + 1);
        scratch.write(&format!("twice-{n}.hal"), next.repeat(2));
    }
    scratch.write("twice-30.hal", "# end\n");
    assert_eq!(scratch.run(scratch.command(&[], "mkfifo").arg("pipe")).status, Some(0));
    let mut wrong = String::new();
    for Row { name, content, way, statuses, says } in ROWS {
        let file = match way {
            Use::Run => {
                scratch.write(name, content());
                name
            }
            Use::Source => {
                scratch.write("sources.hal", format!("source {name}\n"));
                "sources.hal"
            }
        };
        let run = scratch.halrun(&["--virtual", "-f", file]);
        let check = scratch.halcmd(&["check", file]);
        for (output, status) in [run, check].iter().zip(statuses) {
            let all = format!("{}{}", output.stdout, output.stderr);
            if output.status != Some(*status) || !all.contains(says) || all.len() > 20_000 {
                let start: String = all.chars().take(400).collect();
                writeln!(wrong, "{name}: {:?}, {} bytes\n{start}", output.status, all.len())
                    .unwrap();
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Each load costs more than the one before, so that their number is bounded.
#[test]
fn too_many_loads_are_refused() {
    let scratch = Scratch::new("many-loads");
    let mut text = String::new();
    for n in 0..10_000 {
        writeln!(text, "loadrt and2 names=a{n}").unwrap();
    }
    scratch.write("loads.hal", text);
    let run = scratch.halrun(&["--virtual", "-f", "loads.hal"]);
    assert_eq!(run.status, Some(1), "{}", run.stderr);
    let says = ": there are 4096 components already, and an instance has no more";
    assert!(run.stderr.contains(says), "{}", run.stderr);
}
