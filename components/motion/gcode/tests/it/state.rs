//! The state on the way: saved, loaded and gone on from, it gives what the unbroken run gives.

use hal_gcode::{Environment, Interpreter, State, Step};

use crate::support::{World, answer, interpreter, interpreter_of, run};

/// Number of breaks at places of a kind.
#[derive(Default)]
struct Places {
    all: u32,
    subs: u32,
    loops: u32,
    remaps: u32,
    questions: u32,
    compensation: u32,
}

impl Places {
    fn count(&mut self, state: &State) {
        self.all += 1;
        self.subs += u32::from(state.levels.len() > 1);
        self.loops += u32::from(state.levels.iter().any(|l| !l.open.is_empty()));
        self.remaps += u32::from(state.levels.iter().any(|l| l.remapped.is_some()));
        self.questions += u32::from(state.pending.is_some());
        self.compensation += u32::from(!state.compensation.queue.is_empty());
    }
}

/// Runs a program; at step `at`, goes on with an interpreter made of the saved state.
fn broken_run(name: &str, world: &World, at: u32, places: &mut Places) -> (Vec<String>, u32) {
    let mut running = interpreter_of(name);
    running.load(&format!("{name}.ngc"), world.open(name).unwrap());
    let mut out = Vec::new();
    let mut step = 0;
    let mut asked = None;
    loop {
        if step == at {
            let saved = serde_json::to_string(&running.state).unwrap();
            let loaded: State = serde_json::from_str(&saved).unwrap();
            assert_eq!(loaded, running.state, "{name}: saved and loaded at step {at}");
            places.count(&loaded);
            running = Interpreter::from_state(loaded);
        }
        step += 1;
        let result = match asked.take() {
            None => running.next(world, &mut out),
            Some(request) => {
                let reply = answer(&request, &running);
                running.answer(&reply, world, &mut out)
            }
        };
        match result {
            Ok(Step::Line) => {}
            Ok(Step::Ask(request)) => asked = Some(request),
            Ok(Step::Ended) => break,
            Err(error) => {
                let calls = out.iter().map(|i| format!("{i:?}")).chain([error.to_string()]);
                return (calls.collect(), step);
            }
        }
    }
    (out.iter().map(|i| format!("{i:?}")).collect(), step)
}

#[test]
fn a_saved_state_goes_on_as_the_unbroken_run() {
    let world = World::new();
    let mut seed = 12345u32;
    let mut places = Places::default();
    for name in world.files.keys().filter(|n| !n.starts_with("lib-")) {
        let (whole, steps) = broken_run(name, &world, u32::MAX, &mut places);
        let (calls, _) = run(name, &world);
        assert!(whole.len() >= calls.len());
        // Every step of a short program, and random ones of a long one.
        for n in 0..steps.min(24) {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let at = if steps <= 24 { n } else { (seed >> 8) % steps };
            let (broken, _) = broken_run(name, &world, at, &mut places);
            assert_eq!(broken, whole, "{name}: broken at step {at} of {steps}");
        }
    }
    let Places { all, subs, loops, remaps, questions, compensation } = places;
    eprintln!(
        "{all} breaks: {subs} in calls, {loops} in loops, {remaps} in remaps, {questions} at questions"
    );
    assert!(all >= 2000 && subs >= 200 && loops >= 100, "{all} {subs} {loops}");
    assert!(
        remaps >= 50 && questions >= 20 && compensation >= 50,
        "{remaps} {questions} {compensation}"
    );
}

#[test]
fn a_line_of_mdi_uses_the_state_that_a_program_left() {
    let world = World::new();
    let mut it = interpreter();
    let mut out = Vec::new();
    for line in ["g20 g0 x1", "#<_far>=5", "g91 g0 x#<_far>"] {
        it.mdi(line);
        while it.next(&world, &mut out).unwrap() != Step::Ended {}
    }
    let last = out.last().unwrap().call.to_string();
    assert_eq!(last, "STRAIGHT_TRAVERSE(6.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)");
}

#[test]
fn a_call_knows_its_line_and_the_calls_that_led_there() {
    let mut world = World::new();
    world
        .files
        .insert("main".into(), b"o<inner> sub\no<inner> endsub\no<lib-error> call\nm2\n".into());
    world.files.insert(
        "lib-error".into(),
        b"o<lib-error> sub\ng0 x1\n g0  x[1/0]\no<lib-error> endsub\n".into(),
    );
    let (_, error) = run("main", &world);
    let text = error.unwrap().to_string();
    let wanted = "lib-error:3:9: Attempt to divide by zero\n  called from main.ngc:3";
    assert_eq!(text, wanted);
}
