//! Identification of the component code that runs in a thread, by a signal handler.

use super::{
    board::NOBODY,
    doing::{Origin, cycle, running},
    maps,
    sys::{self, Registers},
    text::Text,
};
use crate::{realtime::thread::Thread, sync::Ordering};

/// Describes the code that runs in this thread.
pub(super) fn describe(text: &mut Text, place: Registers, origins: &[Origin]) {
    if let Some(thread) = cycle() {
        cycle_of(text, thread, |text, caller| describe_code(text, place, origins, caller));
        return;
    }
    if let Some(doing) = running() {
        doing.describe(text);
        if let Some(caller) = doing.worker() {
            describe_code(text, place, origins, caller);
        }
        return;
    }
    let mut room = [0; 16];
    let name = sys::thread_name(&mut room);
    let me = sys::thread();
    let own = origins.iter().find(|o| o.threads.contains(&me));
    match own.or_else(|| origin(place, origins)) {
        Some(found) => {
            text.add(format_args!("component '{}'", found.component));
            // A library has several components, and any of them may have begun the thread later.
            let origins = if own.is_some() { &[] } else { origins };
            let same = |o: &&Origin| o.file == found.file && o.component != found.component;
            for other in origins.iter().filter(same) {
                text.add(format_args!(" or '{}'", other.component));
            }
            text.add(format_args!(", a thread of its own ('{name}')"));
        }
        None => text.add(format_args!("thread '{name}' of this process")),
    }
}

/// Describes the function that a thread is in.
pub(super) fn describe_cycle(text: &mut Text, thread: &Thread) {
    cycle_of(text, thread, |_, _| ());
}

/// Describes the function that a thread is in, and hands its component on.
fn cycle_of(text: &mut Text, thread: &Thread, then: impl FnOnce(&mut Text, &str)) {
    let current = thread.current.load(Ordering::Relaxed);
    let list = thread.list.load();
    match list.labels.iter().find(|e| e.id == current && current != NOBODY) {
        Some(e) => {
            text.add(format_args!(
                "component '{}', function '{}', thread '{}'",
                e.component, e.name, thread.name
            ));
            then(text, e.component.as_str());
        }
        None => text.add(format_args!("thread '{}', between its functions", thread.name)),
    }
}

/// Names the component whose code a function of another one has called, such as kinematics. If the code at the place is
/// nobody's, such as `strlen`, the word on top of the stack counts, which on x86 is the return address of a function
/// without a frame. Words below it may be left from calls that have returned.
fn describe_code(text: &mut Text, place: Registers, origins: &[Origin], caller: &str) {
    let return_address = || {
        let mut top = [0];
        (sys::peek(place.stack, &mut top) == 1).then_some(top[0])
    };
    let found = code_of(place.code, origins)
        .or_else(|| return_address().and_then(|address| code_of(address, origins)));
    let Some(found) = found else { return };
    let is_own = |o: &Origin| o.file == found.file && o.component.as_str() == caller;
    if !origins.iter().any(is_own) {
        text.add(format_args!(", in code of component '{}'", found.component));
    }
}

/// Returns the library of an address of code.
fn code_of(address: usize, origins: &[Origin]) -> Option<&Origin> {
    let mut found = None;
    maps::each(|code, path| {
        let here = code.holds(address);
        if here {
            found = origins.iter().find(|o| is_from(&o.file, path));
        }
        here
    });
    found
}

/// Returns whether a mapping is that of a file, or of a copy of it in memory.
fn is_from(file: &str, path: &str) -> bool {
    let copy = path.strip_prefix("/memfd:").and_then(|p| p.strip_suffix(" (deleted)"));
    file == path || copy.is_some() && copy == file.rsplit('/').next()
}

/// Returns the library that code belongs to: that of the address, or that of the innermost caller
/// on the stack.
fn origin(place: Registers, origins: &[Origin]) -> Option<&Origin> {
    code_of(place.code, origins).or_else(|| caller_of(place.stack, origins))
}

/// Returns the library of the innermost caller on a stack.
fn caller_of(stack: usize, origins: &[Origin]) -> Option<&Origin> {
    const MAX_RANGES: usize = 64;
    const MAX_WORDS: usize = 4096;
    const AT_ONCE: usize = 64;
    let mut ranges = [(maps::Code::default(), 0_usize); MAX_RANGES];
    let mut used = 0;
    maps::each(|code, path| {
        if let Some(i) = origins.iter().position(|o| is_from(&o.file, path))
            && let Some(range) = ranges.get_mut(used)
        {
            *range = (code, i);
            used += 1;
        }
        used == MAX_RANGES
    });
    let ranges = ranges.get(..used).unwrap_or_default();
    let found = |address: usize| {
        let range = ranges.iter().find(|(code, _)| code.holds(address));
        range.and_then(|(_, i)| origins.get(*i))
    };
    let mut words = [0_usize; AT_ONCE];
    let mut at = stack & !(align_of::<usize>() - 1);
    for _ in 0..MAX_WORDS / AT_ONCE {
        let n = sys::peek(at, &mut words);
        let read = words.get(..n).unwrap_or_default();
        if let Some(origin) = read.iter().find_map(|word| found(*word)) {
            return Some(origin);
        }
        if n < AT_ONCE {
            return None;
        }
        at = at.saturating_add(size_of_val(&words));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::{Registers, Text, describe};
    use crate::{
        ends::doing::{Activity, Control, Doing},
        name::Name,
    };

    #[test]
    fn a_copy_in_memory_is_of_its_file() {
        let from = |path| super::is_from("/home/x/mykins.so", path);
        assert!(from("/home/x/mykins.so") && from("/memfd:mykins.so (deleted)"));
        assert!(!from("/memfd:kins.so (deleted)") && !from("/home/mykins.so"));
    }

    #[test]
    fn what_runs_is_known_while_it_runs() {
        let name = |text| Name::parse("command", text).unwrap();
        let said = || {
            let mut text = Text::new();
            describe(&mut text, Registers { code: 0, stack: 0 }, &[]);
            text.as_str().to_owned()
        };
        let control = Control::default();
        assert!(said().starts_with("thread '"), "{}", said());
        let outer = control.run(Doing::new("mine", Activity::Load));
        assert_eq!(said(), "component 'mine', as it is loaded");
        let before = control.beats();
        drop(control.run(Doing::new("other", Activity::Command(name("other.go")))));
        assert!(control.beats() > before);
        assert_eq!(said(), "component 'mine', as it is loaded");
        assert!(control.doing().is_some());
        drop(outer);
        assert!(said().starts_with("thread '") && control.doing().is_none());
    }
}
