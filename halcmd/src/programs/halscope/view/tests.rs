//! Effects of keys, and the resulting screens.

use super::{
    paint,
    state::{Asked, State},
};
use crate::{
    programs::halscope::names::chosen,
    terminal::screen::{Key, Look},
};
use hal_protocol::Type;
use hal_trace::Trace;
use ratatui::{Terminal, backend::TestBackend};

/// A signal of 200 Hz for 100 ms, sampled every 100 µs, and a ramp of one unit per millisecond.
fn trace() -> Trace {
    let mut t = Trace::default();
    t.add("stepgen.0.step", Type::Bit);
    t.add("stepgen.0.position-fb", Type::Float);
    t.also(0, "xstep");
    for i in 0..=1000_u32 {
        let position = f64::from(i / 10);
        t.push(i64::from(i) * 100_000, &[u64::from(i % 50 == 20), position.to_bits()]).unwrap();
    }
    t.mark(50_000_000, "trigger: xstep rises");
    t
}

fn view(words: &[&str]) -> State {
    let words: Vec<String> = words.iter().map(|w| (*w).to_owned()).collect();
    let trace = trace();
    let chosen = chosen(&trace, &words, "t.vcd").unwrap();
    State::new(trace, "t.vcd".to_owned(), chosen)
}

fn keys(state: &mut State, letters: &str) {
    for c in letters.chars() {
        let key = if c == '\n' { Key::Enter } else { Key::Letter(c) };
        assert_ne!(state.press(key), Asked::Leave, "{letters}");
    }
}

/// Returns the screen as text.
fn screen(state: &mut State, width: u16, height: u16) -> Vec<String> {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal.draw(|frame| paint::paint(state, "", &Look::new(), frame)).unwrap();
    let buffer = terminal.backend().buffer();
    let line = |y| (0..width).map(|x| buffer[(x, y)].symbol()).collect::<String>();
    (0..height).map(|y| line(y).trim_end().to_owned()).collect()
}

#[test]
fn a_jog_is_found_zoomed_and_measured() {
    let mut state = view(&[]);
    // The first edge becomes A, the window surrounds it, and the second rise becomes B.
    keys(&mut state, "/xstep\nn++++");
    keys(&mut state, "bn");
    let lines = screen(&mut state, 90, 14);
    assert_eq!(lines[0], "t.vcd   -48.125 ms to -41.875 ms, 0 is at 50 ms");
    assert!(lines[1].contains('A') && lines[1].contains('B'), "{lines:#?}");
    let measured = &lines[11];
    assert_eq!(lines[10].split("   ").collect::<Vec<_>>()[2], "B-A 5 ms (200 Hz)", "{lines:#?}");
    assert!(measured.starts_with("stepgen.0.step from A to B: "), "{measured}");
    assert!(measured.contains("1 rises, 1 falls"), "{measured}");
    assert_eq!(lines[12], "at A TRUE   at B TRUE");
    // The whole trace: 200 Hz, high for a fiftieth of the time.
    keys(&mut state, "cf");
    let lines = screen(&mut state, 90, 14);
    assert!(
        lines[11].contains("in view: 200 Hz, high 2 %, period 5 ms, high for 100 µs"),
        "{}",
        lines[11]
    );
}

#[test]
fn a_screen_is_as_it_should_be() {
    let mut state = view(&["xstep", "stepgen.0.position-fb"]);
    (state.from, state.to, state.zero) = (0, 12_000_000, 0);
    let lines = screen(&mut state, 74, 14);
    assert_eq!(lines[0], "t.vcd   0 s to 12 ms");
    assert_eq!(lines[1].split_whitespace().collect::<String>(), "╵0ms╵5ms╵10ms");
    assert_eq!(lines[2], "xstep                             ╷                   ╷");
    assert_eq!(
        lines[3],
        "  FALSE                   ────────┴───────────────────┴───────────────────"
    );
    assert_eq!(lines[5].split_whitespace().next(), Some("stepgen.0.position-fb"));
    assert_eq!(lines[8].split("  ").nth(1), Some("0 to 11"));
    assert!(lines[13].ends_with("q leave"));
    // Screens that are too small to paint on cause no error.
    for (width, height) in [(1, 1), (26, 3), (27, 6), (40, 8), (300, 60)] {
        screen(&mut state, width, height);
    }
}

#[test]
fn cursors_go_from_edge_to_edge_and_bring_themselves_into_view() {
    let mut state = view(&["xstep"]);
    let at = |state: &State| state.cursors[state.active].unwrap();
    keys(&mut state, "n");
    assert_eq!(at(&state), 2_000_000);
    keys(&mut state, "n");
    assert_eq!(at(&state), 2_100_000);
    keys(&mut state, "p");
    assert_eq!(at(&state), 2_000_000);
    keys(&mut state, "p");
    assert_eq!(
        (at(&state), state.said.as_str()),
        (2_000_000, "stepgen.0.step does not change earlier")
    );
    keys(&mut state, "++++++++");
    state.press(Key::End);
    assert!(state.from > 90_000_000);
    keys(&mut state, "m");
    assert_eq!((at(&state), state.said.as_str()), (50_000_000, "trigger: xstep rises"));
    assert!(state.from <= 50_000_000 && 50_000_000 < state.to);
    let width = state.to - state.from;
    state.press(Key::PageDown);
    assert_eq!(state.to - state.from, width, "panning keeps the width");
    keys(&mut state, "ab");
    state.cursors = [Some(10_000_000), Some(20_000_000)];
    keys(&mut state, "z");
    assert_eq!((state.from, state.to), (9_500_000, 20_500_000));
}

#[test]
fn a_condition_is_gone_to_and_a_trigger_is_asked_for() {
    let mut state = view(&[]);
    keys(&mut state, "gstepgen.0.position-fb > 41.5\n");
    assert_eq!(state.cursors[0], Some(42_000_000), "{}", state.said);
    keys(&mut state, "gxstep rises\n");
    assert_eq!(state.cursors[0], Some(47_000_000), "later than where it is: {}", state.said);
    assert_eq!(state.said, "");
    keys(&mut state, "gstepgen.0.position-fb > 1000\n");
    assert_eq!(state.said, "'stepgen.0.position-fb > 1000' does not hold later");
    keys(&mut state, "gy > 1\n");
    assert!(state.said.contains("'y'"), "{}", state.said);
    keys(&mut state, "w/nonexistent/t.vcd\n");
    assert!(state.said.starts_with("/nonexistent/t.vcd: "), "{}", state.said);
    state.ask(super::state::Typed::Trigger);
    keys(&mut state, "xstep");
    assert_eq!(state.press(Key::Enter), Asked::Trigger("xstep".to_owned()));
}

#[test]
fn the_next_capture_stands_where_the_last_one_stood() {
    let mut state = view(&[]);
    keys(&mut state, "n+++");
    let (from, to, cursor) = (state.from, state.to, state.cursors[0].unwrap());
    let mut later = Trace::default();
    later.add("stepgen.0.step", Type::Bit);
    later.add("stepgen.0.position-fb", Type::Float);
    later.push(1_000_000_000, &[0, 0]).unwrap();
    later.push(1_100_000_000, &[1, 0]).unwrap();
    later.mark(1_050_000_000, "trigger: xstep rises");
    state.replace(later);
    assert_eq!((state.from, state.to), (from + 1_000_000_000, to + 1_000_000_000));
    assert_eq!(state.cursors[0], Some(cursor + 1_000_000_000));
    assert_eq!(state.time(1_050_000_000), "0 s");
}

#[test]
fn lanes_are_found_moved_and_hidden() {
    let mut state = view(&[]);
    let names = |state: &State| {
        state.lanes.iter().map(|l| l.chosen.name.clone()).collect::<Vec<_>>().join(" ")
    };
    keys(&mut state, "/posit\n");
    assert_eq!(state.selected, 1);
    keys(&mut state, "K]]");
    assert_eq!(names(&state), "stepgen.0.position-fb stepgen.0.step");
    assert_eq!((state.selected, state.lanes[0].height), (0, 6));
    keys(&mut state, "x");
    assert_eq!(names(&state), "stepgen.0.step");
    keys(&mut state, "x");
    assert_eq!(names(&state), "");
    screen(&mut state, 80, 20);
    keys(&mut state, "nz,/position\n");
    assert_eq!(names(&state), "stepgen.0.position-fb");
    keys(&mut state, "/xstpe\n");
    assert_eq!(state.said, "there is no 'xstpe'; did you mean xstep?");
    keys(&mut state, "u");
    assert_eq!(state.lanes.len(), 2);
    assert_eq!(state.press(Key::Letter('q')), Asked::Leave);
}

#[test]
fn no_key_ever_harms() {
    let keys = [
        Key::Enter,
        Key::Tab,
        Key::Back,
        Key::Up,
        Key::Down,
        Key::PageUp,
        Key::PageDown,
        Key::Home,
        Key::End,
        Key::Left,
        Key::Right,
        Key::Other,
    ];
    let letters = "+-=fz/KJ[]xuabc,.<>npm?h ".chars().map(Key::Letter);
    let keys: Vec<Key> = keys.into_iter().chain(letters).collect();
    let mut seed = 1_u64;
    for trace in [trace(), Trace::default()] {
        let chosen = chosen(&trace, &[], "t").unwrap();
        let mut state = State::new(trace, "t".to_owned(), chosen);
        for i in 0..3000 {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let key = keys[usize::try_from(seed >> 33).unwrap() % keys.len()];
            state.press(key);
            assert!(state.from < state.to, "{key:?}");
            if i % 50 == 0 {
                screen(&mut state, 60, 18);
            }
        }
    }
}
