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
        ("missing", "dlopen: "),
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

/// A driver in the style of the kernel: it gives the names of the system's port calls to those of the interface.
const PORTS: &str = "#define rtapi_inl inl\n#define rtapi_outl outl\n#include <asm/io.h>\n\
                     #if LINUX_VERSION_CODE < KERNEL_VERSION(2, 6, 24)\n#error old\n#endif\n\
                     #include \"motion.h\"\n#include \"posemath.h\"\n\
                     RTAPI_BEGIN_DECLS\nstatic double far[EMCMOT_MAX_JOINTS];\nRTAPI_END_DECLS";

/// Refuses to load unless a turn is the same after two conversions, and turns x where roll, pitch and yaw say.
const TURNS: &str = "const PmRpy in = {10 * TO_RAD, -20 * TO_RAD, 30 * TO_RAD}; PmRpy back; PmRotationMatrix m, i, one;\n\
                     const PmRpy quarter = {0, 0, PM_PI_2}; PmCartesian x = {2, 0, 0}; double d;\n\
                     pmRpyMatConvert(&in, &m); pmMatRpyConvert(&m, &back);\n\
                     if (fabs(back.r - in.r) + fabs(back.p - in.p) + fabs(back.y - in.y) > 1e-12) return -ERANGE;\n\
                     pmMatInv(&m, &i); pmMatMatMult(&m, &i, &one);\n\
                     if (fabs(one.x.x - 1) + fabs(one.y.z) + fabs(one.z.z - 1) > 1e-12) return -ERANGE;\n\
                     pmRpyMatConvert(&quarter, &m); pmMatCartMult(&m, &x, &x); pmCartMag(&x, &d);\n\
                     if (fabs(x.y - 2) + fabs(x.x) + fabs(d - 2) > 1e-12) return -EDOM;\n\
                     if (!rtapi_request_region(0x300, 8, \"mine\")) return -EBUSY;\n\
                     far[0] = pmSqrt(-1); if (far[0] != 0) return -EDOM;";

#[test]
fn drivers_of_the_kernel_find_their_headers() {
    let scratch = Scratch::new("compat-headers");
    let turns = "rtapi_outl(rtapi_inl(0x300) + inb(0x304), 0x300); outb(1, 0x305);";
    let source = component(PORTS, TURNS, turns);
    if compile(scratch.path(), "mine", &source, &[]).is_none() {
        return;
    }
    let mut b = Bench::new(&[scratch.path()]);
    b.load_c("", "mine").unwrap();
    script(&mut b, "loadrt threads name1=t period1=1000000\naddf mine.0 t\nstart\nrun 1000000");
    let sent = b.call(Request::Get { name: "mine.sim.0305".into() }).unwrap();
    assert!(format!("{sent:?}").contains("U32(1)"), "{sent:?}");
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
