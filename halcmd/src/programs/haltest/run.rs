//! Run of a test: it creates the machine and executes the steps.

use super::{
    bench::Bench,
    inject::{self, Faults, Ramping},
    instant::{END, START},
    outcome::{Complaint, Spot},
    settings,
    step::{Action, Step, text_of},
    test::{Entry, Named, Test},
    watch,
};
use crate::{
    Bytes, Captured, Error, Outcome, Session, Style,
    language::units::duration,
    programs::halrun::{
        Files, instance_options, machine,
        plan::{self, Plan, Script},
        prepare,
    },
};
use hal_engine::Engine;
use hal_protocol::{Link, Reply, Request};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::Child,
};

/// Name of the recording, in the machine's folder.
const RECORDING: &str = ".haltest.vcd";

/// Result of a run.
#[derive(Debug, Default)]
pub(super) struct Run {
    pub(super) complaints: Vec<Complaint>,
    /// True if the run ended early. Its expectations are not evaluated then.
    pub(super) aborted: bool,
    /// Time in nanoseconds and line of a step that failed. Nothing after it was carried out.
    pub(super) failed: Option<(i64, Spot)>,
    /// Messages and their times in nanoseconds.
    pub(super) said: Vec<(i64, String)>,
    /// Times at which marks were reached, in nanoseconds.
    pub(super) reached: BTreeMap<String, i64>,
    /// Path of the recording.
    pub(super) recording: Option<PathBuf>,
    pub(super) end: i64,
}

/// State of a running test.
struct Fixture<'t> {
    test: &'t Test,
    plan: &'t Plan,
    files: &'t Files,
    bench: Bench,
    programs: Vec<Child>,
    /// Output and errors of the script and of the steps, with their times.
    printed: Vec<(i64, String)>,
    run: Run,
}

/// Runs a test in this process, whose working folder must be the machine's.
pub(super) fn run(test: &Test, script: &str) -> Run {
    let spot = test.machine.clone().unwrap_or_default().spot;
    let mut words = vec!["--virtual".to_owned()];
    words.extend(test.arguments.iter().cloned());
    words.push(script.to_owned());
    let failed = |text: String| {
        let complaints = vec![Complaint::new(&spot, text)];
        Run { complaints, aborted: true, ..Run::default() }
    };
    let environment = |name: &str| std::env::var(name).ok();
    let plan = match plan::plan(&words, &environment) {
        Ok(plan::Action::Run(plan)) => plan,
        Ok(_) => return failed("the arguments are not those of a run".to_owned()),
        Err(error) => return failed(error.whole()),
    };
    let mut files = match prepare(&plan) {
        Ok(files) => files,
        Err(error) => return refusal(test, &spot, &error),
    };
    if let Err(complaint) = settings::change(test, files.ini.as_mut()) {
        return Run { complaints: vec![complaint], aborted: true, ..Run::default() };
    }
    let engine = match Engine::new(instance_options(&plan, &files)) {
        Ok(engine) => engine,
        Err(failure) => return failed(failure.to_string()),
    };
    let mut fixture = Fixture {
        test,
        plan: &plan,
        files: &files,
        bench: Bench::new(engine, test.limit_ns()),
        programs: Vec::new(),
        printed: Vec::new(),
        run: Run::default(),
    };
    fixture.go(&spot);
    fixture.close()
}

/// Returns the result for a script or INI file that cannot be read.
fn refusal(test: &Test, spot: &Spot, error: &Error) -> Run {
    let mut run = Run::default();
    run.said.push((0, error.whole()));
    run.complaints.extend(refused_as_expected(test, spot, &error.whole()));
    run.aborted = !run.complaints.is_empty();
    run
}

/// Returns the complaint about a failed script, unless the test expects that failure.
fn refused_as_expected(test: &Test, spot: &Spot, text: &str) -> Option<Complaint> {
    match &test.refused {
        Some(wanted) if text.contains(&wanted.name) => None,
        Some(wanted) => Some(
            Complaint::new(&wanted.spot, "the machine is refused for another reason")
                .with(format!("expected: {}", wanted.name))
                .with(format!("found:    {}", text.trim_end().replace('\n', "\n              "))),
        ),
        None => {
            let complaint = Complaint::new(spot, "the machine is refused");
            Some(text.trim_end().lines().fold(complaint, Complaint::with))
        }
    }
}

impl Fixture<'_> {
    fn go(&mut self, spot: &Spot) {
        let (outcome, text) = self.script();
        if outcome != Outcome::Good {
            self.run.complaints.extend(refused_as_expected(self.test, spot, &text));
            self.run.aborted = !self.run.complaints.is_empty();
            return self.check_exit(1);
        }
        if let Some(wanted) = &self.test.refused {
            let complaint = Complaint::new(&wanted.spot, "the machine is not refused");
            self.run.complaints.push(complaint.with(format!("expected: {}", wanted.name)));
            self.run.aborted = true;
            return;
        }
        self.run.complaints.extend(watch::unknown(self.test, &mut self.bench));
        if !self.run.complaints.is_empty() {
            self.run.aborted = true;
            return;
        }
        let start = self.bench.now();
        self.run.reached.insert(START.to_owned(), start);
        for step in &self.test.steps {
            if self.bench.is_ending() {
                let text = "the machine has ended before this step";
                self.end_at(step, Complaint::new(&step.spot, text));
                break;
            }
            if let Err(complaint) = self.step(step, start) {
                // Later steps would find the machine in an unexpected state.
                self.end_at(step, complaint);
                break;
            }
        }
        let stopped = !self.bench.is_ending() && self.bench.has_stopped().unwrap_or(false);
        self.check_exit(u8::from(stopped));
    }

    /// Ends the run at a step that failed, and adds the number of steps that are skipped.
    fn end_at(&mut self, step: &Step, mut complaint: Complaint) {
        let after = self.test.steps.iter().skip_while(|s| s.spot != step.spot).skip(1).count();
        if let Some(steps) = counted(&[(after, "step")]) {
            complaint = complaint.with(format!("not carried out after this: {steps}"));
        }
        self.run.complaints.push(complaint);
        self.run.failed = Some((self.bench.now(), step.spot.clone()));
    }

    fn check_exit(&mut self, found: u8) {
        if let Some((spot, wanted)) = &self.test.exit
            && *wanted != found
        {
            let text = format!("halrun would end with status {found}");
            let complaint = Complaint::new(spot, text).with(format!("expected: {wanted}"));
            self.run.complaints.push(complaint);
        }
    }

    /// Creates the machine by running its script.
    fn script(&mut self) -> (Outcome, String) {
        let mut terminal = Captured::default();
        let watched = watch::recorded(self.test);
        let mut session = Session::new(
            &mut self.bench,
            &mut terminal,
            self.plan.style,
            self.plan.options.place.name(),
        );
        if let Some(ini) = &self.files.ini {
            session.set_ini(ini);
        }
        if !watched.is_empty() {
            let path = RECORDING.to_owned();
            session.before_start(Request::Record { path, patterns: watched });
        }
        let mut outcome = match (&self.plan.script, &self.files.ini) {
            (Script::Hal(path), _) => session.file(path, Bytes::new(self.files.script.clone())),
            (Script::Ini(path), Some(ini)) => {
                machine::start(&mut session, ini, Path::new(path), true)
            }
            _ => Outcome::Good,
        };
        for lines in &self.test.lines {
            if outcome == Outcome::Good {
                outcome = session.file(&lines.spot.file, numbered(lines));
            }
        }
        let outcome = session.settle(outcome);
        self.programs.extend(session.into_programs());
        self.heard(&terminal);
        (outcome, terminal.err)
    }

    fn heard(&mut self, terminal: &Captured) {
        let now = self.bench.now();
        self.printed.extend(terminal.all.lines().map(|line| (now, line.to_owned())));
    }

    fn step(&mut self, step: &Step, start: i64) -> Result<(), Complaint> {
        if let Some(at) = step.at {
            self.run_to(step, start.saturating_add(i64::try_from(at).unwrap_or(i64::MAX)), start)?;
        }
        match &step.action {
            Action::Mark => {}
            Action::Do { lines, fails, prints } => {
                self.lines(step, lines, fails.as_deref(), prints.as_deref())?;
            }
            Action::Run(ns) => {
                let until = self.bench.now().saturating_add(i64::try_from(*ns).unwrap_or(i64::MAX));
                self.run_until(step, until)?;
            }
            Action::Wait { until, within } => {
                watch::wait(&mut self.bench, until, *within)?;
            }
            Action::Set(entries) => {
                for e in entries {
                    let named = Named { spot: e.spot.clone(), name: e.name.clone() };
                    inject::set(&mut self.bench, &named, &text_of(&e.value))?;
                }
            }
            Action::Ramp(ramps) => {
                ramps.iter().try_for_each(|r| Ramping::begin(&mut self.bench, r))?;
            }
            Action::Force(entries) => {
                entries.iter().try_for_each(|e| Faults::force(&mut self.bench, e))?;
            }
            Action::Stuck(names) => {
                names.iter().try_for_each(|n| Faults::stick(&mut self.bench, n))?;
            }
            Action::Unlink(names) => {
                names.iter().try_for_each(|n| Faults::unlink(&mut self.bench, n))?;
            }
            Action::Drop(drops) => {
                drops.iter().try_for_each(|(n, p)| Faults::drop(&mut self.bench, n, *p))?;
            }
            Action::Release(names) => {
                names.iter().try_for_each(|n| Faults::release(&mut self.bench, n))?;
            }
            Action::Expect(entries, tolerance) => self.expect(entries, *tolerance),
        }
        if let Some(mark) = &step.mark {
            self.run.reached.insert(mark.clone(), self.bench.now());
        }
        Ok(())
    }

    /// Advances time to the moment at which a step is due.
    fn run_to(&mut self, step: &Step, due: i64, start: i64) -> Result<(), Complaint> {
        let now = self.bench.now();
        if due < now {
            let since = |t: i64| duration(t.saturating_sub(start).unsigned_abs());
            let text =
                format!("this step is due at {}, when it is {} already", since(due), since(now));
            return Err(Complaint::new(&step.spot, text)
                .with("the steps before it take longer: 'at' is the time after the start"));
        }
        self.run_until(step, due)
    }

    fn run_until(&mut self, step: &Step, until: i64) -> Result<(), Complaint> {
        let ns = until.saturating_sub(self.bench.now()).unsigned_abs();
        if ns == 0 {
            return Ok(());
        }
        let result = self.bench.call(Request::Run { ns });
        result.map(|_| ()).map_err(|f| Complaint::new(&step.spot, f.to_string()))
    }

    fn lines(
        &mut self,
        step: &Step,
        lines: &Named,
        fails: Option<&str>,
        prints: Option<&str>,
    ) -> Result<(), Complaint> {
        let mut terminal = Captured::default();
        let style = Style { silent: false, ..self.plan.style };
        let mut session =
            Session::new(&mut self.bench, &mut terminal, style, self.plan.options.place.name());
        if let Some(ini) = &self.files.ini {
            session.set_ini(ini);
        }
        let outcome = session.file(&lines.spot.file, numbered(lines));
        self.programs.extend(session.into_programs());
        self.heard(&terminal);
        let said = terminal.err.trim_end();
        match (outcome, fails) {
            (Outcome::Failed, None) => {
                let complaint = Complaint::new(&step.spot, "this is refused");
                return Err(said.lines().fold(complaint, Complaint::with));
            }
            (Outcome::Failed, Some(wanted)) if !said.contains(wanted) => {
                return Err(Complaint::new(&step.spot, "this is refused for another reason")
                    .with(format!("expected: {wanted}"))
                    .with(format!("found:    {}", said.replace('\n', "\n              "))));
            }
            (Outcome::Good, Some(wanted)) => {
                return Err(Complaint::new(
                    &step.spot,
                    "this is carried out, and should be refused",
                )
                .with(format!("expected: {wanted}")));
            }
            _ => {}
        }
        match prints {
            Some(wanted) if !terminal.out.contains(wanted) && !terminal.err.contains(wanted) => {
                let printed = terminal.all.trim_end().replace('\n', "\n              ");
                Err(Complaint::new(&step.spot, "this prints something else")
                    .with(format!("expected: {wanted}"))
                    .with(format!("found:    {printed}")))
            }
            _ => Ok(()),
        }
    }

    /// Compares values. A difference changes nothing in the machine, so the test goes on.
    fn expect(&mut self, entries: &[Entry], tolerance: f64) {
        for e in entries {
            let named = Named { spot: e.spot.clone(), name: e.name.clone() };
            let compared = inject::value(&mut self.bench, &named).and_then(|found| {
                super::compare::value(&e.spot, &e.name, &e.value, tolerance, found)
            });
            self.run.complaints.extend(compared.err());
        }
    }

    /// Ends the recording, if there is one. If there is none, the expectations report that.
    fn end_recording(&mut self) {
        let Ok(Reply::Status(status)) = self.bench.ask(Request::Status) else { return };
        if status.recording.is_none() && status.recording_stopped.is_none() {
            return;
        }
        if let Err(failure) = self.bench.ask(Request::EndRecord) {
            let spot = self.test.machine.clone().unwrap_or_default().spot;
            self.run.complaints.push(Complaint::new(&spot, failure.to_string()));
            self.run.aborted = true;
        }
    }

    fn close(mut self) -> Run {
        let ended = self.bench.now();
        self.run.end = ended;
        if self.run.failed.is_none() {
            self.run.reached.insert(END.to_owned(), ended);
        }
        if !watch::recorded(self.test).is_empty() && !self.bench.is_ending() {
            self.end_recording();
        }
        self.run.recording = Some(PathBuf::from(RECORDING)).filter(|p| p.is_file());
        self.run.said = self.bench.close();
        self.run.said.extend(self.printed);
        self.run.said.sort_by_key(|(time, _)| *time);
        for mut program in self.programs {
            drop(program.wait());
        }
        self.run
    }
}

/// Returns how many there are of each, in words; `None` if there are none.
pub(super) fn counted(all: &[(usize, &str)]) -> Option<String> {
    let some = all.iter().filter(|(n, _)| *n > 0);
    let some: Vec<String> =
        some.map(|(n, what)| format!("{n} {what}{}", if *n == 1 { "" } else { "s" })).collect();
    (!some.is_empty()).then(|| some.join(", "))
}

/// Returns lines of a test, preceded by empty lines so that they keep their line numbers.
fn numbered(lines: &Named) -> Bytes {
    let before = "\n".repeat(lines.spot.line.saturating_sub(1) as usize);
    Bytes::new((before + &lines.name).into_bytes())
}
