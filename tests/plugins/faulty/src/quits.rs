//! `quits`: ends its process, or does not return.
use hal_component::{
    Arg, Builder, Component, Error, Out, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};
use std::{
    sync::{
        Arc,
        atomic::{AtomicU32, Ordering::Relaxed},
    },
    thread::sleep,
    time::Duration,
};

/// Run in which a function does it.
const RUN: u32 = 3;

/// Ends its process or does not return, as requested.
#[derive(Debug)]
pub(crate) struct Quits;

#[derive(Debug, Touch)]
struct Count {
    runs: Out<u32>,
    #[state]
    how: Option<String>,
    #[state]
    told: Arc<AtomicU32>,
}

/// Does it when it is dropped.
#[derive(Debug)]
struct EndsProcess(String);

impl EndsProcess {
    const fn keep(&self) {}
}

impl Drop for EndsProcess {
    fn drop(&mut self) {
        quit(&self.0);
    }
}

impl Component for Quits {
    const NAME: &'static str = "quits";
    const DOC: &'static str = "Ends its process, or does not come back, as it is told to.";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::text("how", "How: exit, abort, segv and others.").or(""),
        &Arg::text("where", "Where: function, command, thread, task, create, open, stop, drop.")
            .or("function"),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let (how, at) =
            (b.arg_text("how").unwrap_or_default(), b.arg_text("where").unwrap_or_default());
        let told = Arc::new(AtomicU32::new(0));
        let count = Count {
            runs: b.item("quits.runs", "How often its function ran.", 0)?,
            how: (at == "function").then(|| how.clone()),
            told: told.clone(),
        };
        b.function("quits.0", "Counts.", count)?;
        let go = how.clone();
        b.command("quits.go", "Does it.", &[], move |_| {
            quit(&go);
            Ok(())
        })?;
        match at.as_str() {
            "create" => tell_and_quit(&how),
            "open" => b.on_open(move |_| {
                tell_and_quit(&how);
                Ok(())
            })?,
            "stop" => b.on_stop(move || quit(&how))?,
            "drop" => {
                let last = EndsProcess(how);
                b.on_stop(move || last.keep())?;
            }
            "task" => b.task("quits.task", "Does it.", 1_000_000, Later { how, told })?,
            "thread" => {
                let worker = std::thread::Builder::new().name("worker".into());
                let run = move || {
                    while told.load(Relaxed) < RUN {
                        sleep(Duration::from_millis(1));
                    }
                    quit(&how);
                };
                drop(worker.spawn(run));
            }
            _ => {}
        }
        Ok(())
    }
}

impl Update for Count {
    fn update(&mut self, _: Period) {
        let runs = self.runs.get().wrapping_add(1);
        self.runs.set(runs);
        if runs == RUN {
            eprintln!("third run");
        }
        // Other threads then end the process, and the cycle does not wait for a busy disk meanwhile.
        self.told.store(runs, Relaxed);
        match self.how.as_deref() {
            Some("slow") => {
                eprintln!("run {runs}");
                sleep(Duration::from_millis(40));
            }
            Some(how) if runs == RUN => quit(how),
            _ => {}
        }
    }
}

#[derive(Debug, Touch)]
struct Later {
    #[state]
    how: String,
    #[state]
    told: Arc<AtomicU32>,
}

impl Update for Later {
    fn update(&mut self, _: Period) {
        if self.told.load(Relaxed) >= RUN {
            quit(&self.how);
        }
    }
}

fn tell_and_quit(how: &str) {
    eprintln!("third run");
    quit(how);
}

fn quit(how: &str) {
    unsafe extern "C" {
        safe fn _exit(status: i32) -> !;
        safe fn _Exit(status: i32) -> !;
        safe fn quick_exit(status: i32) -> !;
    }
    let raise = |signal| {
        // SAFETY: a signal to this thread.
        unsafe { libc::raise(signal) };
    };
    match how {
        "exit" => std::process::exit(3),
        "exit-0" => std::process::exit(0),
        "at-once" => _exit(4),
        "at-once-in-c" => _Exit(4),
        "quick-exit" => quick_exit(5),
        "abort" => std::process::abort(),
        "panic" => panic!("told to"),
        // SAFETY: it is meant to end the process.
        "system-call" => drop(unsafe { libc::syscall(libc::SYS_exit_group, 6) }),
        // SAFETY: as above.
        "kill" => drop(unsafe { libc::kill(libc::getpid(), libc::SIGKILL) }),
        "execute" => {
            use std::os::unix::process::CommandExt;
            drop(std::process::Command::new("sleep").arg("1").exec());
        }
        "segv" => {
            let nowhere: *mut u8 = core::hint::black_box(core::ptr::null_mut());
            // SAFETY: none: it is meant to crash.
            unsafe { nowhere.write_volatile(1) };
        }
        "bus" => bus(),
        "fpe" => fpe(),
        "ill" => ill(),
        "port" => port(),
        "stack" => drop(deeper(&[0; 4096])),
        "raise-segv" => raise(libc::SIGSEGV),
        "raise-bus" => raise(libc::SIGBUS),
        "raise-fpe" => raise(libc::SIGFPE),
        "raise-ill" => raise(libc::SIGILL),
        "raise-abrt" => raise(libc::SIGABRT),
        "hang" => {
            eprintln!("it does not return");
            loop {
                sleep(Duration::from_secs(1));
            }
        }
        "spin" => {
            eprintln!("it does not return");
            // Without the processor's pause, which takes emulators much longer than its time.
            loop {
                core::hint::black_box(());
            }
        }
        _ => {}
    }
}

fn deeper(from: &[u8; 4096]) -> u8 {
    let mut room = [0_u8; 4096];
    room[0] = core::hint::black_box(from)[0];
    if room[0] == 1 {
        return 1;
    }
    deeper(core::hint::black_box(&room)).wrapping_add(room[0])
}

/// Reads beyond the end of a file.
fn bus() {
    // SAFETY: an empty file of this function's.
    let file = unsafe { libc::memfd_create(c"empty".as_ptr(), 0) };
    let (prot, flags) = (libc::PROT_READ, libc::MAP_SHARED);
    // SAFETY: new memory.
    let at = unsafe { libc::mmap(core::ptr::null_mut(), 4096, prot, flags, file, 0) };
    // SAFETY: none: it is meant to crash.
    core::hint::black_box(unsafe { at.cast::<u8>().read_volatile() });
}

#[cfg(target_arch = "x86_64")]
fn fpe() {
    // SAFETY: none: it is meant to crash.
    unsafe {
        core::arch::asm!("xor ecx, ecx", "div ecx", out("eax") _, out("edx") _, out("ecx") _)
    };
}

#[cfg(target_arch = "x86_64")]
fn ill() {
    // SAFETY: none: it is meant to crash.
    unsafe { core::arch::asm!("ud2") };
}

/// Writes a port without the right to, also as root.
#[cfg(target_arch = "x86_64")]
fn port() {
    const RAWIO: u32 = 17;
    let head = [0x2008_0522_u32, 0];
    let mut sets = [[0_u32; 3]; 2];
    // SAFETY: live records, as the system has them.
    unsafe { libc::syscall(libc::SYS_capget, head.as_ptr(), sets.as_mut_ptr()) };
    sets[0][0] &= !(1 << RAWIO);
    // SAFETY: as above.
    unsafe { libc::syscall(libc::SYS_capset, head.as_ptr(), sets.as_ptr()) };
    // SAFETY: none: it is meant to be refused.
    unsafe { core::arch::asm!("out dx, al", in("dx") 0x378_u16, in("al") 1_u8) };
}

#[cfg(not(target_arch = "x86_64"))]
fn fpe() {
    quit("raise-fpe");
}

#[cfg(not(target_arch = "x86_64"))]
fn ill() {
    quit("raise-ill");
}

#[cfg(not(target_arch = "x86_64"))]
fn port() {}
