//! Components in C that are compiled here: loads that are refused, and the report of a crash.

use hal_protocol::{Kind, Link, Reply, Request};
use hal_tests::{
    foreign::{Bench, compile, component},
    machine::{bit, script},
    scratch::Scratch,
    tools,
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

/// Sources as LinuxCNC's tool compiles them: what they include, and what must be true as they are loaded.
const SOURCES: &[(&str, &str)] = &[
    (
        "#include \"kinematics.h\"",
        "fabs(180 * TO_RAD - M_PI) < 1e-12 && fabs(M_PI * TO_DEG - 180) < 1e-9",
    ),
    (
        "#include \"emcmotcfg.h\"",
        "EMCMOT_MAX_JOINTS == 16 && EMCMOT_MAX_AXIS == 9 && EMCMOT_MAX_DIO == 64 && EMCMOT_MAX_SPINDLES == 8",
    ),
    (
        "static uint mine = 3; static ulong far = 4; static ushort near = 5;",
        "mine + far + near == 12",
    ),
    // A driver of the kernel: clocks by the processor's frequency, declared by itself in one way or another.
    ("#include <asm/tsc.h>", "cpu_khz == 1000000"),
    ("extern unsigned long cpu_khz;", "cpu_khz == 1000000"),
    (
        "extern unsigned int cpu_khz;\nstatic unsigned long factor(void) { return (cpu_khz << 6) / 15625ul; }",
        "factor() == 4096",
    ),
];

/// The hostmot2 of this test: each call of its function is added up.
const CHANNEL: &str = "#undef hm2_bspi_setup_chan\n\
    int hm2_bspi_setup_chan(char *name, int chan, int cs, int bits, double mhz, int delay, int cpol, int cpha,\n\
    int noclear, int noecho, int samplelate)\n{\n (void)name; (void)mhz;\n return chan + cs + bits + delay + cpol + \
    cpha + noclear + noecho + 1000 * samplelate;\n}";

#[test]
fn sources_that_linuxcnc_compiles() {
    if tools::compiler().is_none() {
        return;
    }
    let scratch = Scratch::new("compat-sources");
    let load = |source: &str| {
        scratch.write("mine.c", source);
        let output = scratch.run(scratch.command(&[], "halcompile").args(["-c", "mine.c"]));
        assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""), "{source}");
        Bench::new(&[scratch.path()]).load_c("", "mine").unwrap();
    };
    for (globals, holds) in SOURCES {
        let globals = format!("#include \"rtapi_math.h\"\n{globals}");
        load(&component(&globals, &format!("if (!({holds})) return -EDOM;"), ""));
    }
    // The function for a channel of SPI has one argument more than it had.
    let calls = "if (hm2_bspi_setup_chan(\"x\", 1, 2, 3, 4.0, 5, 6, 7, 8, 9) != 41) return -EDOM;\n\
                 if (hm2_bspi_setup_chan(\"x\", 1, 2, 3, 4.0, 5, 6, 7, 8, 9, 1) != 1041) return -EDOM;";
    let source = component("#include \"hostmot2-serial.h\"", calls, "");
    load(&format!("{source}\n{CHANNEL}\n"));
}

/// Kinematics of two types: type 1 swaps the axes. The module also tries the mathematics of its headers.
const KINS: &str = r#"
#include "gomath.h"
#include "switchkins.h"
static int try_all(void)
{
    const go_rpy turn = {0.1, -0.2, 0.3};
    go_quat q;
    go_rpy back;
    go_quat_rpy_convert((go_rpy_quat_convert(&turn, &q), &q), &back);
    if (fabs(back.r - 0.1) + fabs(back.p + 0.2) + fabs(back.y - 0.3) > 1e-12) return -ERANGE;
    const go_pose p = {{1, 2, 3}, q};
    go_pose i, one;
    if (go_pose_inv(&p, &i) || go_pose_pose_mult(&p, &i, &one)) return -ERANGE;
    if (fabs(one.rot.s - 1) + fabs(one.tran.x) + fabs(one.tran.y) + fabs(one.tran.z) > 1e-12) return -ERANGE;
    const go_rpy half = {3.0, 0, 0};
    go_rpy_quat_convert(&half, &q);
    if (fabs(q.s - cos(1.5)) + fabs(q.x - sin(1.5)) > 1e-12) return -ERANGE;
    GO_MATRIX_DECLARE(m, m_space, 3, 3);
    GO_MATRIX_DECLARE(w, w_space, 3, 3);
    go_matrix_init(m, m_space, 3, 3);
    go_matrix_init(w, w_space, 3, 3);
    const go_real given[9] = {0, 2, 0, 1, 0, 3, 0, 0, 4};
    const go_real v[3] = {1, 2, 3};
    go_real there[3], home[3];
    for (int k = 0; k < 9; k++) m.el[k] = given[k];
    if (go_matrix_inv(&m, &w) || go_matrix_vector_mult(&m, v, there) || go_matrix_vector_mult(&w, there, home))
        return -EDOM;
    if (there[0] != 4 || there[1] != 10 || there[2] != 12) return -EDOM;
    if (fabs(home[0] - 1) + fabs(home[1] - 2) + fabs(home[2] - 3) > 1e-12) return -EDOM;
    m.el[1] = 0;
    return go_matrix_inv(&m, &w) == GO_RESULT_SINGULAR ? 0 : -EDOM;
}
static int straight(const double *j, EmcPose *p, const KINEMATICS_FORWARD_FLAGS *f, KINEMATICS_INVERSE_FLAGS *i)
{ (void)f; (void)i; p->tran.x = j[0]; p->tran.y = j[1]; return 0; }
static int crossed(const double *j, EmcPose *p, const KINEMATICS_FORWARD_FLAGS *f, KINEMATICS_INVERSE_FLAGS *i)
{ (void)f; (void)i; p->tran.x = j[1]; p->tran.y = j[0]; return 0; }
static int straight_back(const EmcPose *p, double *j, const KINEMATICS_INVERSE_FLAGS *i, KINEMATICS_FORWARD_FLAGS *f)
{ (void)f; (void)i; j[0] = p->tran.x; j[1] = p->tran.y; return 0; }
static int crossed_back(const EmcPose *p, double *j, const KINEMATICS_INVERSE_FLAGS *i, KINEMATICS_FORWARD_FLAGS *f)
{ (void)f; (void)i; j[0] = p->tran.y; j[1] = p->tran.x; return 0; }
static hal_bit_t **works;
static int prepare(const int component, const char *axes, kparms *parms)
{
    int of_joint[2] = {0};
    works = hal_malloc(sizeof *works);
    if (hal_pin_bit_newf(HAL_OUT, works, component, "%s.works", parms->halprefix)) return -EINVAL;
    int code = try_all();
    if (code) return code;
    if (switchkins_axes(axes, 2, of_joint) != 2 || of_joint[1] != 1) return -EINVAL;
    double joints[2] = {1, 2};
    static EmcPose pose;
    kinematicsSwitch(5) == -1 || (code = -1);
    kinematicsForward(joints, &pose, NULL, NULL);
    kinematicsInverse(&pose, joints, NULL, NULL);
    **works = code == 0 && pose.tran.y == 2 && joints[0] == 1 && kinematicsSwitchable();
    return 0;
}
int switchkinsSetup(kparms *parms, KS *s0, KS *s1, KS *s2, KF *f0, KF *f1, KF *f2, KI *i0, KI *i1, KI *i2)
{
    (void)s1; (void)s2; (void)f2; (void)i2;
    parms->kinsname = parms->halprefix = "crosskins";
    parms->required_coordinates = "xy";
    *s0 = prepare; *f0 = straight; *f1 = crossed; *i0 = straight_back; *i1 = crossed_back;
    return 0;
}
MODULE_LICENSE("GPL");
"#;

#[test]
fn kinematics_of_several_types_are_made_by_their_header() {
    let scratch = Scratch::new("compat-switchkins");
    let options = ["-Wno-unused-value"];
    if compile(scratch.path(), "crosskins", KINS, &options).is_none() {
        return;
    }
    let mut b = Bench::new(&[scratch.path()]);
    let said = b.load_c("", "crosskins coordinates=xz").unwrap_err();
    assert!(said.contains("crosskins: coordinates=xz has no 'y'"), "{said}");
    b.load_c("", "crosskins coordinates=xy").unwrap();
    assert!(bit(&mut b, "crosskins.works") && bit(&mut b, "kinstype.is-0"));
    assert!(!bit(&mut b, "kinstype.is-1"));
    assert_eq!(b.items(Kind::Pins, "").len(), 3);
}

#[test]
fn a_driver_of_a_pci_card_finds_none() {
    let scratch = Scratch::new("compat-pci");
    let globals = "#include \"rtapi_pci.h\"\n#include \"hostmot2-serial.h\"\n\
        static int probe(struct rtapi_pci_dev *d, const struct rtapi_pci_device_id *id)\n\
        { (void)id; rtapi_pci_set_drvdata(d, rtapi_pci_ioremap_bar(d, 0)); return rtapi_pci_enable_device(d); }\n\
        static const struct rtapi_pci_device_id ids[] = {{RTAPI_PCI_DEVICE(0x10b5, 0x9054)}, {0}};\n\
        static struct rtapi_pci_driver driver = {.name = \"mine\", .id_table = ids, .probe = probe};";
    let main = "int code = rtapi_pci_register_driver(&driver); if (code) return code;";
    if compile(scratch.path(), "mine", &component(globals, main, ""), &[]).is_none() {
        return;
    }
    let said = Bench::new(&[scratch.path()]).load_c("", "mine").unwrap_err();
    assert!(said.contains("mine: PCI devices are not offered here"), "{said}");
    assert!(said.contains("No such device (-19)"), "{said}");
}

#[test]
fn a_port_is_a_number_in_c() {
    let scratch = Scratch::new("compat-port");
    let globals = "static hal_port_t **port, **back; static hal_u32_t **got;";
    let main = "port = hal_malloc(sizeof *port); back = hal_malloc(sizeof *back); got = hal_malloc(sizeof *got);\n\
        _Static_assert(sizeof(hal_port_t) == sizeof(int), \"an int\");\n\
        if (hal_pin_port_new(\"mine.port\", HAL_OUT, port, id)) return -EINVAL;\n\
        if (hal_pin_port_new(\"mine.back\", HAL_IN, back, id)) return -EINVAL;\n\
        if (hal_pin_u32_new(\"mine.got\", HAL_OUT, got, id)) return -EINVAL;";
    let turn = "char two[3] = \"\"; int handle = **port; hal_port_write(handle, \"ab\", 2);\n\
        if (hal_port_readable(**back) == 2 && hal_port_read(**back, two, 2)) **got += two[1];";
    if compile(scratch.path(), "mine", &component(globals, main, turn), &[]).is_none() {
        return;
    }
    let mut b = Bench::new(&[scratch.path()]);
    b.load_c("", "mine").unwrap();
    script(&mut b, "loadrt threads name1=t period1=1000000\naddf mine.0 t\nstart\nrun 1000000");
    let got = |b: &mut Bench| b.call(Request::Get { name: "mine.got".into() }).unwrap();
    assert!(format!("{:?}", got(&mut b)).contains("U32(0)"), "no port is linked yet");
    script(&mut b, "newsig p port\nlinkps mine.port p\nlinkps mine.back p\nsets p 16\nrun 1000000");
    assert!(format!("{:?}", got(&mut b)).contains("U32(98)"), "{:?}", got(&mut b));
}

#[test]
fn a_second_name_of_a_module_is_a_component_that_leaves_with_it() {
    let scratch = Scratch::new("compat-names");
    let globals = "static int second; static hal_bit_t **mine;";
    let main = "second = hal_init(\"second\"); mine = hal_malloc(sizeof *mine);\n\
        if (second < 0 || second == id || hal_init(\"second\") >= 0) return -EINVAL;\n\
        if (__builtin_strcmp(hal_comp_name(second), \"second\")) return -EINVAL;\n\
        if (__builtin_strcmp(hal_comp_name(id), \"mine\")) return -EINVAL;\n\
        if (hal_pin_bit_new(\"second.pin\", HAL_OUT, mine, second)) return -EINVAL;\n\
        hal_ready(second);";
    if compile(scratch.path(), "mine", &component(globals, main, "**mine = 1;"), &[]).is_none() {
        return;
    }
    let mut b = Bench::new(&[scratch.path()]);
    let names = |b: &mut Bench| {
        let all = Request::List { kind: Kind::Components, patterns: Vec::new(), ty: None };
        let Ok(Reply::Components(list)) = b.call(all) else { return Vec::new() };
        let mut names: Vec<String> = list.into_iter().map(|c| c.name).collect();
        names.retain(|name| name == "mine" || name == "second");
        names.sort();
        names
    };
    b.load_c("", "mine").unwrap();
    assert_eq!(names(&mut b), ["mine", "second"]);
    let Ok(Reply::Components(second)) = b.call(Request::Component { name: "second".to_owned() })
    else {
        panic!("no component")
    };
    assert_eq!(b.items(Kind::Pins, "second.pin")[0].owner, second[0].id);
    b.call(Request::Unload { name: "mine".to_owned() }).unwrap();
    assert_eq!(names(&mut b), [""; 0]);
    assert!(b.items(Kind::Pins, "second.pin").is_empty());
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
    for (name, symbol) in [("ourhome", "do_homing"), ("ourtp", "tpRunCycle")] {
        let source = component(&format!("int {symbol}(void) {{ return 0; }}"), "", "");
        if compile(scratch.path(), name, &source, &[]).is_none() {
            return;
        }
        let mut b = Bench::new(&[scratch.path()]);
        let loaded = b.load_c("", name);
        let said = b.engine.take_messages().join("\n");
        if symbol == "do_homing" {
            // Homing is taken, but as a whole.
            let why = loaded.unwrap_err();
            assert!(why.contains("it has homing without homing_init"), "{why}");
        } else {
            loaded.unwrap();
            let text = "this trajectory planner module has no effect on motmod";
            assert!(said.contains(text), "{said}");
        }
    }
}
