//! The components of `tests/comp`: compiled by halcompile, loaded by halrun, and compared to their tables. `CASE=name`
//! selects those whose names begin with that text.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{
    programs::{programs, root},
    scratch::{Scratch, until},
    tools,
    trace::replay,
};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Returns the files with this ending.
fn files(ending: &str) -> Vec<PathBuf> {
    let wanted = std::env::var("CASE").unwrap_or_default();
    let folder = fs::read_dir(root().join("tests/comp")).unwrap();
    let mut files: Vec<PathBuf> = folder.map(|e| e.unwrap().path()).collect();
    files.retain(|p| p.extension().is_some_and(|e| e == ending) && name(p).starts_with(&wanted));
    files.sort();
    files
}

fn name(path: &Path) -> String {
    path.file_stem().unwrap().to_string_lossy().into_owned()
}

/// Asserts that the library that loads components in C was built: it has a descriptor.
fn assert_loader() {
    let library = fs::read(programs().join("libcompat.so")).unwrap();
    assert!(dynamic_symbols(&library).iter().any(|s| s == "hal_library_compat"));
}

/// Compiles a file into a folder of its own.
fn compiled(file: &Path) -> Result<Scratch, String> {
    let scratch = Scratch::new(&name(file));
    let mut command = scratch.command(&[], "halcompile");
    let output = scratch.run(command.arg("--compile").arg(file));
    match output.status {
        Some(0) if output.stderr.is_empty() => Ok(scratch),
        status => Err(format!("{}: {status:?}\n{}", file.display(), output.stderr)),
    }
}

/// Runs a function for every file, several at once; panics with the list of all failures.
fn for_each(files: &[PathBuf], run: impl Fn(&Path) -> Result<usize, String> + Sync) -> usize {
    const LANES: usize = 4;
    let done: Vec<Result<usize, String>> = std::thread::scope(|scope| {
        let lanes: Vec<_> = (0..LANES)
            .map(|lane| {
                let run = &run;
                let own = files.iter().skip(lane).step_by(LANES);
                scope.spawn(move || {
                    own.map(|f| run(f).map_err(|e| format!("{}\n{e}", f.display())))
                        .collect::<Vec<_>>()
                })
            })
            .collect();
        lanes.into_iter().flat_map(|lane| lane.join().unwrap()).collect()
    });
    let (mut rows, mut wrong) = (0, Vec::new());
    for one in done {
        match one {
            Ok(n) => rows += n,
            Err(e) => wrong.push(e),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    rows
}

#[test]
fn every_component_does_what_its_table_says() {
    if tools::compiler().is_none() {
        return;
    }
    assert_loader();
    let tables = files("txt");
    let rows = for_each(&tables, |table| {
        let scratch = compiled(&table.with_extension("comp"))?;
        replay(&fs::read_to_string(table).unwrap(), scratch.path())
    });
    if std::env::var_os("CASE").is_none() {
        assert!(tables.len() >= 40 && rows >= 90, "{} tables, {rows} rows", tables.len());
        assert_eq!(files("comp").len(), tables.len(), "a table for every component");
    }
}

/// A symbol is visible to other modules only if `EXPORT_SYMBOL` exports it.
#[test]
fn symbols_stay_inside() {
    if tools::compiler().is_none() {
        return;
    }
    let scratch =
        compiled(&root().join("tests/comp/shares.comp")).unwrap_or_else(|e| panic!("{e}"));
    let bytes = fs::read(scratch.path().join("shares.so")).unwrap();
    let has = |name: &str| bytes.windows(name.len()).any(|w| w == name.as_bytes());
    let dynamic = dynamic_symbols(&bytes);
    assert!(has("shares_answer"));
    for (name, shown) in [
        ("rtapi_app_main", true),
        ("rtapi_app_exit", true),
        ("rtapi_info_type_count", true),
        ("rtapi_info_address_names", true),
        ("shares_answer", true),
        ("shares_secret", false),
        ("comp_id", false),
    ] {
        assert_eq!(dynamic.iter().any(|d| d == name), shown, "{name}: {dynamic:?}");
    }
}

fn dynamic_symbols(bytes: &[u8]) -> Vec<String> {
    use object::{Object, ObjectSymbol};
    let Ok(file) = object::File::parse(bytes) else { return Vec::new() };
    let defined = file.dynamic_symbols().filter(|s| s.is_definition() && s.is_global());
    defined.map(|s| s.name().unwrap().to_owned()).collect()
}

/// The compiler's messages name lines of the .comp file, and a failed compilation leaves no output.
#[test]
fn what_the_compiler_refuses_is_named_in_the_comp_file() {
    if tools::compiler().is_none() {
        return;
    }
    let scratch = Scratch::new("refused");
    let text = "component wrong;\npin in bit a;\npin out bit b;\nvariable nothing v;\nfunction _;\nlicense \"MIT\";\n;;\nb = a\n";
    scratch.write("wrong.comp", text);
    scratch.write("wrong.so", "what stood here before");
    let output = scratch.run(scratch.command(&[], "halcompile").args(["-c", "wrong.comp"]));
    assert_eq!(output.status, Some(1));
    for part in ["wrong.comp:4:", "wrong.comp:9:", "wrong.comp: cc refused it; nothing was made"] {
        assert!(output.stderr.contains(part), "{part}: {}", output.stderr);
    }
    let names: Vec<String> = scratch.files().into_keys().collect();
    assert_eq!(names, ["wrong.comp", "wrong.so"]);
    assert_eq!(scratch.read("wrong.so"), "what stood here before");
}

/// A symbol that nothing offers is named by function and line when the file is compiled, and not only when it is loaded.
#[test]
fn what_nothing_offers_is_named_by_function_and_line() {
    if tools::compiler().is_none() {
        return;
    }
    let scratch = Scratch::new("unresolved");
    let text = "component calls;\npin out float x;\nfunction _;\nlicense \"MIT\";\n;;\n\
                #include <rtapi_math.h>\nextern double elsewhere(double);\nFUNCTION(_) {\n    x = sin(x) + elsewhere(1);\n}\n";
    scratch.write("calls.comp", text);
    let compiled = || scratch.run(scratch.command(&[], "halcompile").args(["-c", "calls.comp"]));
    let output = compiled();
    assert_eq!(output.status, Some(1));
    for part in [
        "in function `_'",
        "calls.comp:9: undefined reference to `elsewhere'",
        "RTAPI_IMPORT_SYMBOL(NAME)",
    ] {
        assert!(output.stderr.contains(part), "{part}: {}", output.stderr);
    }
    scratch.write("calls.comp", text.replace("FUNC", "RTAPI_IMPORT_SYMBOL(elsewhere)\nFUNC"));
    let output = compiled();
    assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""));
}

/// A source of the right name beside the script or the INI file is named by the error of its line.
#[test]
fn a_source_beside_the_script_is_named() {
    let scratch = Scratch::new("beside");
    fs::create_dir(scratch.path().join("parts")).unwrap();
    scratch.write("mine.comp", "component mine;\n");
    scratch.write("parts/yours.c", "");
    scratch.write("parts/parts.hal", "loadrt yours\n");
    scratch.write(
        "m.hal",
        "loadrt mine names=a\nloadrt --c mine\nloadrt yours\nloadrt and3\nsource parts/parts.hal\n",
    );
    scratch.write("m.ini", "[EMC]\nMACHINE = x\n[HAL]\nHALFILE = parts/mine.hal\n");
    scratch.write("parts/mine.hal", "loadrt mine\n");
    let compile = |source: &str, path: &str, place: &str| {
        format!("{source} lies beside the {place}: compile it with `halcompile --install {path}`")
    };
    let output = scratch.halrun(&["--virtual", "-k", "-f", "m.hal"]);
    for (at, hint) in [
        ("m.hal:1: ", Some(compile("mine.comp", "mine.comp", "script"))),
        ("m.hal:2: ", Some(compile("mine.comp", "mine.comp", "script"))),
        ("m.hal:3: ", None),
        ("m.hal:4: ", None),
        ("parts/parts.hal:1: ", Some(compile("yours.c", "parts/yours.c", "script"))),
    ] {
        let said = output.stderr.lines().filter(|line| line.starts_with(at));
        let said: Vec<&str> = said.filter(|line| line.contains(" lies beside ")).collect();
        match hint {
            Some(hint) => assert!(said.iter().any(|l| l.contains(&hint)), "{}", output.stderr),
            None => assert!(said.is_empty(), "{at}: {}", output.stderr),
        }
    }
    let output = scratch.halrun(&["--virtual", "--headless", "m.ini"]);
    assert!(
        output.stderr.contains("mine.comp lies beside the INI file: compile it with"),
        "{}",
        output.stderr
    );
}

/// LinuxCNC 2.9 ignores `option period no`; what relies on that compiles with `--compat 2.9`; otherwise the error says so.
#[test]
fn a_period_that_a_function_does_not_have() {
    if tools::compiler().is_none() {
        return;
    }
    let scratch = Scratch::new("period");
    let text = "component late;\npin out float x;\noption period no;\nfunction _;\nlicense \"MIT\";\n;;\n\
                FUNCTION(_) { x += fperiod; }\n";
    scratch.write("late.comp", text);
    let compiled = |words: &[&str]| {
        let mut command = scratch.command(&[], "halcompile");
        scratch.run(command.args(["-c", "late.comp"]).args(words))
    };
    let output = compiled(&[]);
    assert_eq!(output.status, Some(1));
    for part in ["late.comp:3:15: ", "the C text uses fperiod", "give --compat 2.9"] {
        assert!(output.stderr.contains(part), "{part}: {}", output.stderr);
    }
    let output = compiled(&["--compat", "2.9"]);
    assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""));
    replay("load late\nrun late.0\nin\nout late.0.x\n| 0.001\n| 0.002\n", scratch.path()).unwrap();
}

/// An installed module is for all users, also if its author keeps files to himself.
#[test]
fn installed_modules_are_for_all_users() {
    use std::os::unix::fs::PermissionsExt;
    if tools::compiler().is_none() {
        return;
    }
    let scratch = Scratch::new("installed");
    scratch
        .write("mine.comp", "component mine;\npin in bit a;\nfunction _;\nlicense \"MIT\";\n;;\n");
    let halcompile = programs().join("halcompile");
    let line = format!("umask 077; exec {} --install mine.comp", halcompile.display());
    let mut shell = scratch.command(&[], "sh");
    shell.env("HAL_RTMOD_DIR", scratch.path().join("modules")).args(["-c", &line]);
    let output = scratch.run(&mut shell);
    assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""));
    let mode = fs::metadata(scratch.path().join("modules/mine.so")).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o644);
}

/// The descriptions in a `.comp` file are in the manual page of its module.
#[test]
fn descriptions_are_in_the_manual() {
    if tools::compiler().is_none() {
        return;
    }
    let scratch = Scratch::new("described");
    scratch.write(
        "gains.comp",
        "component gains \"Multiplies two numbers\";\n\
         pin in float in_##[2] \"one of the numbers: any\";\n\
         param rw float gain \"factor of both\";\n\
         function _ fp \"multiplies them\";\nlicense \"MIT\";\n;;\n",
    );
    let halcompile =
        scratch.run(scratch.command(&[], "halcompile").args(["--compile", "gains.comp"]));
    assert_eq!((halcompile.status, halcompile.stderr.as_str()), (Some(0), ""));
    let page = scratch.run(
        scratch.command(&[], "halcmd").env("HAL_RTMOD_DIR", scratch.path()).args(["man", "gains"]),
    );
    for text in [
        "gains - Multiplies two numbers",
        "one of the numbers: any",
        "factor of both",
        "multiplies them",
    ] {
        assert!(page.stdout.contains(text), "{text}: {}", page.stdout);
    }
}

/// The declaration in Rust compiles unchanged, for every component.
#[test]
fn declarations_in_rust_compile() {
    let scratch = Scratch::new("in-rust");
    let mut lib = String::from("//! Every component of the tests, declared in Rust.\n");
    fs::create_dir(scratch.path().join("src")).unwrap();
    for file in files("comp") {
        let mut command = scratch.command(&[], "halcompile");
        let out = format!("src/{}.rs", name(&file));
        let output = scratch.run(command.arg("--rust").arg("-o").arg(&out).arg(&file));
        assert_eq!(output.status, Some(0), "{}", output.stderr);
        lib.push_str(&format!("mod {};\n", name(&file)));
    }
    scratch.write("src/lib.rs", lib);
    let component = root().join("hal/component");
    scratch.write(
        "Cargo.toml",
        format!(
            "[package]\nname = \"in-rust\"\nversion = \"0.1.0\"\nedition = \"2024\"\n[dependencies]\n\
             hal-component = {{ path = {component:?} }}\n[workspace]\n"
        ),
    );
    fs::copy(root().join("Cargo.lock"), scratch.path().join("Cargo.lock")).unwrap();
    let mut cargo = hal_tests::programs::cargo("check");
    let (target, _) = hal_tests::programs::target();
    cargo.args(["--offline", "--quiet", "--manifest-path"]).arg(scratch.path().join("Cargo.toml"));
    cargo.arg("--target-dir").arg(target.join("test-in-rust")).env("RUSTFLAGS", "-D warnings");
    let output = cargo.output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
}

/// Polls until a pin has this value.
fn becomes(scratch: &Scratch, pin: &str, value: &str) {
    let mut last = String::new();
    let is_so = |last: &mut String| {
        *last = scratch.halcmd(&["getp", pin]).stdout.trim().to_owned();
        *last == value
    };
    until(&format!("{pin} becomes {value}"), || is_so(&mut last));
}

/// A program in C with pins: it joins, exchanges values in both directions, and ends with the instance.
#[test]
fn programs_exchange_their_values() {
    if tools::compiler().is_none() {
        return;
    }
    let scratch = Scratch::new("programs");
    for name in ["counts", "doubles", "greets"] {
        let file = root().join(format!("tests/comp/programs/{name}.comp"));
        fs::copy(&file, scratch.path().join(format!("{name}.comp"))).unwrap();
        let mut command = scratch.command(&[], "halcompile");
        let output = scratch.run(command.args(["--compile", &format!("{name}.comp")]));
        assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""));
    }
    scratch.write(
        "test.hal",
        "loadrt threads\nloadrt mux2\nloadrt sim_parport\nnet level mux2.0.out\nsetp mux2.0.in0 2.5\n\
         setp sim-parport.0.pin-01-out-invert 1\naddf mux2.0 thread1\nstart\nloadusr -W ./doubles\nloadusr -W ./counts\nloadusr -Wn greets ./greets names=ann,bob 42\nprint ready\n",
    );
    let running = scratch.start(scratch.command(&[], "halrun").arg("test.hal"));
    until("the script is through", || running.said().1.contains("MSG: ready"));
    for (pin, value) in [
        ("counts.presses", "0"),
        ("doubles.0.out", "3"),
        ("doubles.0.gone", "TRUE"),
        ("doubles.0.na", "-6"),
        ("doubles.0.nb", "1"),
        ("doubles.0.nc", "-5000000000"),
        ("doubles.0.nd", "18446744073709551615"),
        ("doubles.0.counter", "3"),
        ("doubles.0.row-1", "1.5"),
        ("doubles.0.large", "FALSE"),
        ("ann.out", "1.5"),
        ("bob.first", "42"),
        // Values of other components, by their names.
        ("bob.other", "2.5"),
        ("bob.linked", "TRUE"),
        ("bob.line", "2.5"),
        ("bob.driven", "TRUE"),
        ("bob.inverts", "TRUE"),
        ("bob.missing", "TRUE"),
        ("bob.waited", "TRUE"),
    ] {
        becomes(&scratch, pin, value);
    }
    for (pin, value) in [
        ("counts.press", "1"),
        ("doubles.0.in", "8"),
        ("doubles.0.gain", "0.25"),
        ("doubles.0.go", "0"),
        ("doubles.0.counter", "10"),
        ("bob.times", "8"),
        ("mux2.0.in0", "-4"),
    ] {
        assert_eq!(scratch.halcmd(&["setp", pin, value]).status, Some(0), "{pin}");
    }
    for (pin, value) in [
        ("counts.presses", "5"),
        ("doubles.0.out", "2"),
        ("doubles.0.gone", "FALSE"),
        ("doubles.0.counter", "20"),
        ("doubles.0.row-1", "8"),
        ("doubles.0.large", "TRUE"),
        ("bob.out", "4"),
        ("ann.out", "1.5"),
        ("bob.other", "-4"),
        ("bob.line", "-4"),
    ] {
        becomes(&scratch, pin, value);
    }
    // One ends by itself, and its pins are removed; the other ends with the instance.
    assert_eq!(scratch.halcmd(&["setp", "ann.stop", "1"]).status, Some(0));
    assert_eq!(scratch.halcmd(&["waitusr", "greets"]).status, Some(0));
    assert_eq!(scratch.halcmd(&["getp", "ann.out"]).status, Some(1));
    assert_eq!(scratch.halcmd(&["shutdown"]).status, Some(0));
    assert_eq!(running.wait().status, Some(0));
    assert!(scratch.left().is_empty());
}
