//! Virtual is virtual: components in C that try to reach outside, each in its own way. On the virtual clock and with
//! simulated hardware nothing arrives; on the real clock it does, so that the listeners are known to listen.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_tests::{
    foreign::{compile, component, installed, run_beside},
    programs::root,
    scratch::{Output, Scratch},
    tools,
};
use rustix::{
    fs::{Mode, OFlags},
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
};
use std::{
    collections::BTreeSet,
    fmt::Write,
    fs,
    net::{TcpListener, UdpSocket},
    os::fd::OwnedFd,
    path::Path,
    sync::atomic::{AtomicU8, Ordering::Relaxed},
};

/// Columns of the rows of a table in `tests/compat/outside/`.
fn rows<const N: usize>(file: &str) -> Vec<[String; N]> {
    let text = fs::read_to_string(root().join("tests/compat/outside").join(file)).unwrap();
    let lines = text.lines().filter(|l| !l.is_empty() && !l.starts_with('#'));
    lines
        .map(|line| {
            let (name, rest) = line.split_once(" | ").unwrap();
            // The condition of a call may have bars of its own; its row ends with what the message names.
            let mut cells: Vec<&str> = vec![name];
            if N == 3 {
                let (condition, named) = rest.rsplit_once(" | ").unwrap();
                cells.extend([condition, named]);
            } else {
                cells.extend(rest.splitn(N - 1, " | "));
            }
            let cells: Vec<String> = cells.into_iter().map(str::to_owned).collect();
            cells.try_into().unwrap_or_else(|_| panic!("{file}: {line}"))
        })
        .collect()
}

/// Headers and declarations of everything that the tables call.
const HEADERS: &str = "#include <arpa/inet.h>\n#include <dlfcn.h>\n#include <errno.h>\n#include <fcntl.h>\n\
     #include <ifaddrs.h>\n#include <mqueue.h>\n#include <net/if.h>\n#include <netdb.h>\n#include <netinet/in.h>\n\
     #include <pthread.h>\n#include <pty.h>\n#include <sched.h>\n#include <semaphore.h>\n#include <signal.h>\n\
     #include <spawn.h>\n#include <stdarg.h>\n#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>\n\
     #include <sys/acct.h>\n#include <sys/ioctl.h>\n#include <sys/ipc.h>\n#include <sys/mman.h>\n#include <sys/mount.h>\n\
     #include <sys/msg.h>\n#include <sys/ptrace.h>\n#include <sys/quota.h>\n#include <sys/reboot.h>\n\
     #include <sys/sem.h>\n#include <sys/shm.h>\n#include <sys/socket.h>\n#include <sys/stat.h>\n#include <sys/swap.h>\n\
     #include <sys/syscall.h>\n#include <sys/time.h>\n#include <sys/timex.h>\n#include <sys/uio.h>\n\
     #include <sys/wait.h>\n#include <sys/xattr.h>\n#include <syslog.h>\n#include <termios.h>\n#include <time.h>\n\
     #include <unistd.h>\n#include <utime.h>\n#include <utmp.h>\n#include <wordexp.h>\n";

/// Declarations that no header has, or not in every version.
const DECLARED: &[&str] = &[
    "ssize_t __recv_chk(int, void *, size_t, size_t, int)",
    "ssize_t __recvfrom_chk(int, void *, size_t, size_t, int, void *, void *)",
    "void __syslog_chk(int, int, const char *, ...)",
    "void __vsyslog_chk(int, int, const char *, va_list)",
    "int __open(const char *, int, ...)",
    "int __open_2(const char *, int)",
    "int __open64_2(const char *, int)",
    "int __openat_2(int, const char *, int)",
    "int __openat64_2(int, const char *, int)",
    "int __xmknod(int, const char *, int, void *)",
    "int __xmknodat(int, int, const char *, int, void *)",
    "int res_query(const char *, int, int, void *, int)",
    "int res_search(const char *, int, int, void *, int)",
    "int res_send(const void *, int, void *, int)",
    "int pivot_root(const char *, const char *)",
    "int init_module(void *, unsigned long, const char *)",
    "int delete_module(const char *, int)",
    "int fsopen(const char *, unsigned)",
    "int open_tree(int, const char *, unsigned)",
    "int move_mount(int, const char *, int, const char *, unsigned)",
    "int pidfd_open(int, unsigned)",
    "int pidfd_getfd(int, int, unsigned)",
    "int pidfd_send_signal(int, int, void *, unsigned)",
    "int _Fork(void)",
    "int iopl(int)",
    "int ioperm(unsigned long, unsigned long, int)",
];

/// Returns the source of a component whose parameter `call` chooses a row; its set-up then fails with EPERM if the
/// condition of the row is true, and with EXDEV otherwise.
fn calls(table: &[[String; 3]]) -> String {
    let mut text = String::from(HEADERS);
    for declared in DECLARED {
        writeln!(text, "extern {declared} __attribute__((weak));").unwrap();
    }
    text.push_str(
        "#define FAILS2(x) ((long)(x) == -1 && errno == EPERM)\n\
         #define FAILS(x) (errno = 0, FAILS2(x))\n\
         #define NULLS(x) (errno = 0, (long)(x) == 0 && errno == EPERM)\n\
         #define PLAIN \"/etc/passwd\"\n#define ANY ((void *)room)\n\
         static char room[4096] __attribute__((aligned(16)));\n\
         static int two[2], child, call;\nstatic char *words[] = { \"true\", NULL };\nRTAPI_MP_INT(call, \"row\")\n\
         static void v_log(const char *how, ...)\n{\n va_list list; va_start(list, how);\n \
         if (*how) __vsyslog_chk(7, 1, \"\", list); else vsyslog(7, \"\", list);\n va_end(list);\n}\n",
    );
    for (i, [_, condition, _]) in table.iter().enumerate() {
        writeln!(text, "static int row{i}(void) {{ errno = 0; return {condition}; }}").unwrap();
    }
    let list: Vec<String> = (0..table.len()).map(|i| format!("row{i}")).collect();
    writeln!(text, "static int (*const all[])(void) = {{ {} }};", list.join(", ")).unwrap();
    component(&text, "return all[call]() ? -EPERM : -EXDEV;", "")
}

/// The functions in the table of the folder's page.
fn documented() -> BTreeSet<String> {
    let page = fs::read_to_string(root().join("components/foreign/README.md")).unwrap();
    let (_, table) = page.split_once("| kind | functions |\n").unwrap();
    let rows = table.lines().take_while(|line| line.starts_with('|')).skip(1);
    rows.flat_map(|row| row.split('`').skip(1).step_by(2)).map(str::to_owned).collect()
}

#[test]
fn every_function_that_reaches_outside_is_refused_by_name() {
    let table = rows::<3>("calls.txt");
    let tried: BTreeSet<String> = table.iter().map(|[name, ..]| name.clone()).collect();
    let documented = documented();
    assert!(documented.len() >= 180, "{}", documented.len());
    let missing: Vec<_> = documented.difference(&tried).collect();
    assert!(missing.is_empty(), "no row in calls.txt: {missing:?}");

    let scratch = Scratch::new("outside-calls");
    let source = calls(&table);
    if compile(scratch.path(), "tries", &source, &["-D_GNU_SOURCE", "-w"]).is_none() {
        return;
    }
    let script: String = (0..table.len()).map(|i| format!("loadrt tries call={i}\n")).collect();
    scratch.write("m.hal", script);
    for clock in ["--virtual", "--simulate"] {
        let output = run_beside(&scratch, "halrun", &[clock, "-k", "-f", "m.hal"]);
        let mut wrong = Vec::new();
        for (i, [name, condition, named]) in table.iter().enumerate() {
            let said: Vec<&str> = output.stderr.lines().collect();
            let at = format!("m.hal:{}: ", i + 1);
            let said: Vec<&&str> = said.iter().filter(|line| line.contains(&at)).collect();
            let error = said.iter().find(|line| line.contains("rtapi_app_main: "));
            let refused = format!("it tried {named}");
            let good = error.is_some_and(|line| {
                let answered = line.contains("rtapi_app_main: Operation not permitted (-1)");
                let named = if named == "-" {
                    !line.contains("it tried")
                } else {
                    line.contains(&refused) && line.contains("`--stub tries`")
                };
                answered && named
            });
            if !good {
                wrong.push(format!("{i} {name}: {condition}: {said:?}"));
            }
        }
        assert!(wrong.is_empty(), "{clock}:\n{}\n{}", wrong.join("\n"), output.stderr);
        assert!(!scratch.path().join("made").exists(), "{clock}");
    }
}

/// Listeners for what a component sends.
struct Ears {
    udp: UdpSocket,
    tcp: TcpListener,
    pty: OwnedFd,
    name: String,
}

impl Ears {
    fn new() -> Self {
        let udp = UdpSocket::bind("127.0.0.1:0").unwrap();
        let tcp = TcpListener::bind("127.0.0.1:0").unwrap();
        udp.set_nonblocking(true).unwrap();
        tcp.set_nonblocking(true).unwrap();
        let pty = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&pty).unwrap();
        unlockpt(&pty).unwrap();
        let name = ptsname(&pty, Vec::new()).unwrap().into_string().unwrap();
        rustix::fs::fcntl_setfl(&pty, OFlags::RDWR | OFlags::NONBLOCK).unwrap();
        Self { udp, tcp, pty, name }
    }

    /// Returns what has heard something since the last call. The other side of the pty stays open, so that no byte is
    /// lost there.
    fn heard(&self) -> Vec<&'static str> {
        let mut heard = Vec::new();
        let mut room = [0; 4096];
        while self.udp.recv(&mut room).is_ok() {
            heard.push("udp");
        }
        while self.tcp.accept().is_ok() {
            heard.push("tcp");
        }
        while rustix::io::read(&self.pty, &mut room).is_ok_and(|n| n > 0) {
            heard.push("pty");
        }
        heard.dedup();
        heard
    }

    /// Opens the side of the pty that a component writes to.
    fn far_side(&self) -> OwnedFd {
        let flags = OFlags::RDWR | OFlags::NOCTTY;
        rustix::fs::open(&self.name, flags, Mode::empty()).unwrap()
    }
}

/// Writes the module of a route to a folder. Returns `None` without a compiler.
fn route(folder: &Path, ears: &Ears, place: &str, sends: &str) -> Option<()> {
    let (udp, tcp) = (ears.udp.local_addr().unwrap().port(), ears.tcp.local_addr().unwrap().port());
    let shared = format!(
        "{HEADERS}#define UDP {udp}\n#define TCP {tcp}\n#define PTY \"{}\"\n\
         #define LENGTH ((socklen_t)sizeof(struct sockaddr_in))\n\
         static struct sockaddr *to(int port)\n{{\n static struct sockaddr_in there;\n there.sin_family = AF_INET;\n \
         there.sin_port = htons((unsigned short)port);\n there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);\n \
         return (struct sockaddr *)&there;\n}}\nstatic int gone;\n",
        ears.name
    );
    let mut library = Vec::new();
    let mut globals = shared.clone();
    let (mut main, mut function, mut exit) = (String::new(), String::new(), String::new());
    match place {
        "main" => main = format!("{{ {sends} }}"),
        "function" => function = format!("{{ {sends} }}"),
        "exit" => exit = format!("{{ {sends} }}"),
        "constructor" => {
            writeln!(globals, "__attribute__((constructor)) static void begin(void) {{ {sends} }}")
                .unwrap();
        }
        "library" | "library-constructor" => {
            let mark = if place == "library" { "" } else { "__attribute__((constructor)) " };
            let text = format!("{shared}{mark}void reach(void) {{ {sends} }}\nint there = 1;\n");
            compile(folder, "libreach", &text, &["-D_GNU_SOURCE", "-w"])?;
            library.push(folder.join("libreach.so").display().to_string());
            library.push(format!("-Wl,-rpath,{}", folder.display()));
            globals.push_str("extern void reach(void); extern int there;\n");
            main =
                if place == "library" { "reach();" } else { "if (!there) return -1;" }.to_owned();
        }
        other => panic!("{other}"),
    }
    globals.push_str(
        "static int (*volatile made)(int, int, int) = socket;\n\
         static ssize_t (*volatile gave)(int, const void *, size_t, int, const struct sockaddr *, socklen_t) = sendto;\n\
         static void *far_away(void *arg)\n{\n \
         int s = socket(AF_INET, SOCK_DGRAM, 0);\n sendto(s, \"x\", 1, 0, to(UDP), LENGTH);\n close(s);\n return arg;\n}\n",
    );
    let source =
        component(&globals, &format!("(void)made; (void)gave; (void)far_away; {main}"), &function);
    let source = source.replace("{ hal_exit(id); }", &format!("{{ {exit} hal_exit(id); }}"));
    let mut options = vec!["-D_GNU_SOURCE", "-w", "-Wl,--no-as-needed"];
    options.extend(library.iter().map(String::as_str));
    compile(folder, "mine", &source, &options).map(drop)
}

/// A machine that loads a module, runs its function in a thread, and ends.
const MACHINE: &str = "loadrt threads name1=t period1=1000000\nloadrt mine\naddf mine.0 t\nstart\nloadusr -w true\nrun 5ms\nunloadrt mine\n";

#[test]
fn no_byte_leaves_a_virtual_machine() {
    let ears = Ears::new();
    let _far = ears.far_side();
    let table = rows::<4>("routes.txt");
    assert!(table.len() >= 20);
    for [name, target, place, sends] in &table {
        let scratch = Scratch::new(&format!("outside-{name}"));
        if route(scratch.path(), &ears, place, sends).is_none() {
            return;
        }
        scratch.write("m.hal", MACHINE);
        for clock in ["--virtual", "--simulate"] {
            let output = run_beside(&scratch, "halrun", &[clock, "-k", "-f", "m.hal"]);
            assert!(ears.heard().is_empty(), "{name} {clock}: {}", output.stderr);
            assert!(said(&output), "{name} {clock}: {}", output.stderr);
        }
        let output = run_beside(&scratch, "halrun", &["-f", "m.hal"]);
        assert_eq!(ears.heard(), [target.as_str()], "{name} on the real clock: {}", output.stderr);
        assert!(!said(&output), "{name}: {}", output.stderr);
    }
}

/// Returns whether one line says that something was refused, and for which reason.
fn said(output: &Output) -> bool {
    output.stderr.lines().any(|line| {
        line.contains("under --virtual and --simulate a component in C reaches nothing outside")
    })
}

/// Addresses within code are not redirected.
#[cfg(target_arch = "x86_64")]
#[test]
fn code_that_holds_addresses_is_refused() {
    let scratch = Scratch::new("outside-text");
    let globals = "#include <sys/socket.h>\n";
    let source = component(globals, "if (socket(AF_INET, SOCK_DGRAM, 0) >= 0) return -EXDEV;", "");
    let options = ["-fno-pic", "-mcmodel=large", "-Wl,-z,notext", "-Wl,--warn-textrel"];
    if compile(scratch.path(), "mine", &source, &options).is_none() {
        return;
    }
    scratch.write("m.hal", "loadrt mine\n");
    let output = run_beside(&scratch, "halrun", &["--virtual", "-f", "m.hal"]);
    for part in
        ["mine.so: it has addresses of functions within its code", "it imports socket", "--stub"]
    {
        assert!(output.stderr.contains(part), "{part}: {}", output.stderr);
    }
}

/// A port access by the processor's own instruction needs no import. Nothing permits it, so that it faults, and is
/// served by the simulated ports.
#[cfg(target_arch = "x86_64")]
#[test]
fn ports_by_instruction_are_simulated() {
    let scratch = Scratch::new("outside-ports");
    let main = "unsigned char got = 0; unsigned short port = 0x378;\n\
                if (ioperm(0x378, 3, 1) || iopl(3)) return -EPERM;\n\
                __asm__ volatile(\"outb %0, %1\" :: \"a\"((unsigned char)0x5a), \"Nd\"(port));\n\
                __asm__ volatile(\"inb %1, %0\" : \"=a\"(got) : \"Nd\"(port));\n\
                if (got != 0x5a) return -EIO;\n\
                __asm__ volatile(\"inb %1, %0\" : \"=a\"(got) : \"Nd\"((unsigned short)0x2f8));\n\
                if (got != 0xff) return -EXDEV;";
    let globals = "extern int ioperm(unsigned long, unsigned long, int); extern int iopl(int);";
    if compile(scratch.path(), "mine", &component(globals, main, ""), &[]).is_none() {
        return;
    }
    scratch.write("m.hal", "loadrt mine\ngetp mine.sim.0378\n");
    for clock in ["--virtual", "--simulate"] {
        let output = run_beside(&scratch, "halrun", &[clock, "-f", "m.hal"]);
        assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""), "{clock}");
        assert!(output.stdout.contains("90"), "{}", output.stdout);
    }
}

/// Runs LinuxCNC's driver of an Ethernet card, whose address is one of this computer's own. Returns what it said, and
/// whether a packet came.
fn with_card(program: &str, words: &[&str]) -> Option<(Output, bool)> {
    let folder = installed()?;
    // An address for each process and test: the port of the cards is fixed.
    static CARDS: AtomicU8 = AtomicU8::new(64);
    let net = CARDS.fetch_add(1, Relaxed);
    let [low, high, ..] = std::process::id().to_le_bytes();
    let address = format!("127.{net}.{high}.{}", low | 1);
    let card = UdpSocket::bind((address.as_str(), 27181)).unwrap();
    card.set_nonblocking(true).unwrap();
    let scratch = Scratch::new("outside-card");
    let script = format!("loadrt --c hostmot2\nloadrt --c hm2_eth board_ip={address}\n");
    scratch.write("m.hal", script);
    let mut command = scratch.command(&[], program);
    command.env("HAL_RTMOD_DIR", folder);
    let output = scratch.run(command.args(words).arg("m.hal"));
    let mut room = [0; 2048];
    Some((output, card.recv(&mut room).is_ok()))
}

#[test]
fn no_packet_leaves_for_a_card() {
    if tools::linuxcnc().is_none() {
        return;
    }
    let (output, came) = with_card("halcmd", &["check"]).unwrap();
    assert!(!came && output.stdout.contains("`--stub hm2_eth`"), "check: {}", output.stdout);
    for clock in ["--virtual", "--simulate"] {
        let (output, came) = with_card("halrun", &[clock, "-f"]).unwrap();
        assert!(!came, "{clock}: {}", output.stderr);
        assert_eq!(output.status, Some(1), "{clock}: {}", output.stderr);
        for part in [
            "hm2_eth: rtapi_spawn_as_root '/bin/sh' is refused",
            "socket, and under --virtual",
            "`--stub hm2_eth`",
        ] {
            assert!(output.stderr.contains(part), "{clock}: {part}: {}", output.stderr);
        }
    }
    let (output, came) = with_card("halrun", &["-f"]).unwrap();
    assert!(came, "no packet on the real clock: {}", output.stderr);
}

/// Drivers of cards take functions from `hostmot2`.
#[test]
fn hostmot2_comes_first() {
    let Some(folder) = tools::linuxcnc() else { return };
    for driver in ["hm2_7i43", "hm2_7i90", "hm2_eth", "hm2_pci", "hm2_rpspi", "hm2_spi"] {
        let scratch = Scratch::new("outside-first");
        scratch.write("m.hal", format!("loadrt --c {driver}\n"));
        let mut command = scratch.command(&[], "halrun");
        command.env("HAL_RTMOD_DIR", &folder);
        let output = scratch.run(command.args(["-f", "m.hal"]));
        let part = "undefined symbol: hm2_register; hostmot2 defines it and comes first: `loadrt hostmot2`";
        assert!(output.stderr.contains(part), "{driver}: {}", output.stderr);
    }
}

/// On the real clock a component that runs a program gets a child that has failed, and a person gets the command.
#[test]
fn a_program_as_root_is_a_child_that_fails() {
    let scratch = Scratch::new("outside-root");
    let main = "pid_t child = -1; int status = 0;\n\
                char *words[] = { \"sh\", \"-c\", \"iptables -N mine; touch ran\", NULL };\n\
                if (rtapi_spawn_as_root(&child, \"/bin/sh\", 0, 0, words, 0)) return -EIO;\n\
                if (child <= 0 || waitpid(child, &status, 0) != child) return -ECHILD;\n\
                if (!WIFEXITED(status) || WEXITSTATUS(status) != 1) return -EXDEV;";
    let globals = "#include <sys/wait.h>\n";
    if compile(scratch.path(), "mine", &component(globals, main, ""), &[]).is_none() {
        return;
    }
    scratch.write("m.hal", "loadrt mine\n");
    let output = run_beside(&scratch, "halrun", &["-f", "m.hal"]);
    assert_eq!(output.status, Some(0), "{}", output.stderr);
    assert!(!scratch.path().join("ran").exists());
    let text = format!("{}{}", output.stdout, output.stderr);
    for part in [
        "mine: not run: iptables -N mine; touch ran",
        "iptables -A OUTPUT -o IFACE -p udp -d BOARD_IP --dport 27181 -j ACCEPT",
        "CAP_NET_ADMIN and CAP_NET_RAW",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}
