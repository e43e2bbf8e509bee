//! Components in C that are compiled here: loads that are refused, and the report of a crash.

use hal_protocol::{Kind, Link, Request};
use hal_tests::{
    foreign::{Bench, compile, component},
    machine::{bit, script},
    scratch::Scratch,
};

const PARAMETERS: &str = "static int sizes[2]; RTAPI_MP_ARRAY_INT(sizes, 2, \"sizes\")\n\
                          static int count = 1; RTAPI_MP_INT(count, \"how many\")";

#[test]
fn what_cannot_be_loaded_is_refused_and_leaves_nothing() {
    let scratch = Scratch::new("compat-refused");
    let folder = scratch.path();
    let good = component(PARAMETERS, "", "");
    let Some(file) = compile(folder, "mine", &good, &[]) else { return };
    let mut alien = std::fs::read(file).unwrap();
    // The machine field of the ELF header: AArch64.
    alien.splice(18..20, [0xb7, 0]);
    std::fs::write(folder.join("alien.so"), alien).unwrap();
    let missing = component("extern int nowhere(void);", "if (nowhere()) return -1;", "");
    compile(folder, "missing", &missing, &[]);
    let fails = "rtapi_print_msg(RTAPI_MSG_ERR, \"mine: no board\\n\"); return -ENODEV;";
    compile(folder, "fails", &component("", fails, ""), &[]);
    let mut b = Bench::new(&[folder]);
    for (words, said) in [
        ("alien", "is built for aarch64"),
        ("missing", "undefined symbol: nowhere"),
        ("fails", "rtapi_app_main: No such device (-19)"),
        ("fails", "mine: no board"),
        ("mine colour=1", "Unknown parameter `colour=1'; its parameters: count, sizes"),
        ("mine sizes=1,2,3", "sizes: can only take 2 arguments, and `sizes=1,2,3' has 3"),
        ("mine sizes=1,x", "`x' invalid for parameter `sizes=1,x'"),
        ("mine count", "Invalid parameter `count'"),
        ("absent", "no component in C of this name"),
    ] {
        let refused = b.load_c("", words).unwrap_err();
        assert!(refused.contains(said), "{words}: {refused}");
        assert!(b.items(Kind::Pins, "").is_empty(), "{words}: pins are left");
    }
    b.load_c("", "mine sizes=1,2").unwrap();
    script(&mut b, "loadrt threads name1=t period1=1000000");
    script(&mut b, "addf mine.0 t\nstart\nrun 1000000\nnewsig s bit\nlinkps mine.0.out s");
    assert!(bit(&mut b, "mine.0.out"));
    script(&mut b, "run 1000000");
    assert!(!bit(&mut b, "mine.0.out"), "the pointer follows the link");
    assert!(b.load_c("p.", "mine").unwrap_err().contains("is loaded already in this process"));
    script(&mut b, "unloadrt mine");
    b.load_c("p.", "mine").unwrap();
    b.call(Request::Get { name: "p.mine.0.out".into() }).unwrap();
}

#[test]
fn a_crash_names_component_and_function() {
    let scratch = Scratch::new("compat-crash");
    let source = component("static int *volatile nowhere;", "", "*nowhere = 1;");
    if compile(scratch.path(), "mine", &source, &[]).is_none() {
        return;
    }
    let lines =
        "loadrt threads name1=t period1=1000000\nloadrt mine\naddf mine.0 t\nstart\nrun 1s\n";
    std::fs::write(scratch.path().join("crash.hal"), lines).unwrap();
    let mut halrun = scratch.command(&[], "halrun");
    halrun.env("HAL_RTMOD_DIR", scratch.path()).args(["--virtual", "-f", "crash.hal"]);
    let output = scratch.run(&mut halrun);
    let said = "component 'mine', function 'mine.0', thread 't': segmentation fault at address 0x0";
    assert!(output.stderr.contains(said), "{}", output.stderr);
    assert_eq!(output.status, None, "it ends by its signal");
}

#[test]
fn a_part_of_their_motion_controller_says_that_ours_does_not_take_it() {
    let scratch = Scratch::new("compat-part");
    for (name, symbol, part) in
        [("ourhome", "do_homing", "homing"), ("ourtp", "tpRunCycle", "trajectory planner")]
    {
        let source = component(&format!("int {symbol}(void) {{ return 0; }}"), "", "");
        if compile(scratch.path(), name, &source, &[]).is_none() {
            return;
        }
        let mut b = Bench::new(&[scratch.path()]);
        b.load_c("", name).unwrap();
        let said = b.engine.take_messages().join("\n");
        assert!(said.contains(&format!("this {part} module has no effect on motmod")), "{said}");
    }
}
