//! Scheduling, processor and memory of an instance's threads, and messages about them.

use crate::{
    ClockKind, Error, Options, RealtimeOptions,
    graph::Graph,
    graph::arena::Arena,
    os::{self, memory, processors},
    realtime::overruns::{Overran, Overruns},
    realtime::runners::Scheduling,
    realtime::shared::Shared,
    realtime::stuck::StuckWatch,
    realtime::thread::NOBODY,
    sync::{Arc, Ordering},
};

/// Priority of the thread that looks for stuck threads: above all HAL threads.
pub(crate) const WATCH_PRIORITY: i32 = 91;
/// Priority of the fastest thread: below the kernel's own threads.
pub(crate) const FASTEST_PRIORITY: i32 = 90;

/// Extent of locked memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Locking {
    /// No memory: nothing runs under `SCHED_FIFO`.
    Nothing,
    /// All present and future memory.
    All,
    /// As much as the limit allows.
    Part,
}

/// Realtime properties of an instance.
#[derive(Debug)]
pub(crate) struct Realtime {
    pub(crate) scheduling: Scheduling,
    pub(crate) cpu: Option<usize>,
    /// Description of the scheduling, as a sentence.
    pub(crate) words: String,
    locking: Locking,
    /// Messages about missing rights, logged once when threads run.
    notes: Vec<String>,
    overruns: Overruns,
    watch: Option<StuckWatch>,
}

impl Realtime {
    /// Determines what the system allows.
    pub(crate) fn find(options: &Options) -> Result<Self, Error> {
        let mut found = Self {
            scheduling: Scheduling::Timeline,
            cpu: None,
            words: "virtual time: all threads in one place".to_owned(),
            locking: Locking::Nothing,
            notes: Vec::new(),
            overruns: Overruns::default(),
            watch: None,
        };
        if options.clock == ClockKind::Virtual {
            return Ok(found);
        }
        let (cpu, isolated) = choose_cpu(options.place.name(), &options.realtime)?;
        found.cpu = cpu;
        let forbidden = std::env::var_os("HAL_NO_FIFO").is_some();
        let refusal = if forbidden {
            Some("HAL_NO_FIFO is set".to_owned())
        } else {
            os::fifo_refusal(WATCH_PRIORITY)
        };
        if let Some(why) = refusal {
            found.words = format!(
                "no SCHED_FIFO ({why}): one ordinary thread runs all threads in turn; expect late \
                 wake-ups"
            );
            found.notes.push(format!(
                "realtime: no SCHED_FIFO, threads may be late: {why}; see \"Real time\" in \
                 README.md"
            ));
        } else {
            found.scheduling = Scheduling::Fifo;
            let cpu = cpu.map_or("any processor".into(), |c| format!("processor {c}"));
            let isolated = if isolated { " (isolated)" } else { "" };
            found.words = format!("SCHED_FIFO, all threads on {cpu}{isolated}");
        }
        Ok(found)
    }

    /// Locks memory before the first system thread starts.
    pub(crate) fn lock_memory(&mut self, arena: &Arena) {
        if self.scheduling != Scheduling::Fifo || self.locking != Locking::Nothing {
            return;
        }
        if memory::may_lock_all() && memory::lock_all() {
            self.locking = Locking::All;
            // Address space that is only reserved must not count as locked.
            arena.unlock_rest();
        } else {
            self.locking = Locking::Part;
        }
    }

    /// Locks memory that was added since, if not all memory may be locked.
    pub(crate) fn lock_more(&self) {
        if self.locking == Locking::Part {
            memory::lock_present();
        }
    }

    /// Prepares for running threads: locks memory and starts the watch for stuck threads. Returns
    /// once the messages about what is missing.
    pub(crate) fn begin(&mut self, shared: &Arc<Shared>) -> Vec<String> {
        self.lock_more();
        if self.watch.is_some() {
            return Vec::new();
        }
        let fifo = self.scheduling == Scheduling::Fifo;
        self.watch = StuckWatch::begin(shared.clone(), fifo, self.cpu);
        if self.locking == Locking::Part {
            self.notes.extend(partly_locked());
        }
        core::mem::take(&mut self.notes)
    }

    /// Makes the watch check for new threads.
    pub(crate) fn renew_watch(&self) {
        if let Some(watch) = &self.watch {
            watch.poke();
        }
    }

    /// Ends the watch.
    pub(crate) fn end_watch(&mut self) {
        self.watch = None;
    }

    /// Returns messages about threads that have missed their time; `ends` reports all that is left.
    pub(crate) fn overruns(&mut self, shared: &Shared, graph: &Graph, ends: bool) -> Vec<String> {
        let threads = shared.threads.load_full();
        let read = |n: &crate::sync::AtomicI64| n.load(Ordering::Relaxed);
        let late = threads.iter().filter(|t| t.overruns.load(Ordering::Relaxed) > 0);
        let late: Vec<Overran> = late
            .map(|t| {
                let guilty = t.guilty.load(Ordering::Relaxed);
                Overran {
                    id: t.id,
                    thread: t.name.as_str().to_owned(),
                    period_ns: t.period_ns,
                    overruns: t.overruns.load(Ordering::Relaxed),
                    missed: t.missed.load(Ordering::Relaxed),
                    guilty: (guilty != NOBODY).then(|| graph.funct_name(guilty)),
                    late_ns: read(&t.over_late),
                    took_ns: read(&t.over_took),
                }
            })
            .collect();
        self.overruns.look(shared.now(), &late, ends)
    }
}

/// Returns the message that not all memory may be locked.
fn partly_locked() -> Option<String> {
    let (locked, present) = memory::locked_and_present()?;
    let limit = memory::lock_limit().map_or_else(|| "exceeded".to_owned(), in_mib);
    Some(format!(
        "realtime: {} of {} of memory are locked, the rest may be pushed out: RLIMIT_MEMLOCK is \
         {limit} and must be unlimited; see \"Real time\" in README.md",
        in_mib(locked),
        in_mib(present)
    ))
}

fn in_mib(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}

/// Chooses the processor for all threads of an instance, and returns whether it is isolated: the
/// requested one, else one of the isolated processors by the instance's name, or else one of all,
/// the last first.
fn choose_cpu(instance: &str, options: &RealtimeOptions) -> Result<(Option<usize>, bool), Error> {
    let isolated = processors::isolated();
    if let Some(cpu) = options.cpu {
        if !processors::may_use(cpu) {
            return Err(Error::System {
                what: "the threads cannot run on the processor of --cpu (HAL_CPU)",
                why: format!("processor {cpu} is not there; there are {}", processors::online())
                    .into(),
            });
        }
        return Ok((Some(cpu), isolated.contains(&cpu)));
    }
    let may: Vec<usize> = isolated.into_iter().filter(|c| processors::may_use(*c)).collect();
    let is_isolated = !may.is_empty();
    let cpus = if is_isolated { may } else { processors::cpus() };
    let n = cpus.len();
    if n < 2 && !is_isolated {
        return Ok((None, false));
    }
    let spread = if instance == "default" { 0 } else { instance.bytes().map(usize::from).sum() };
    Ok((cpus.get((n - 1 + n - spread % n) % n).copied(), is_isolated))
}
