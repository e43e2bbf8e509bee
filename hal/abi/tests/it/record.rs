//! Records of older and newer versions, and invalid lists and strings.
#![expect(unsafe_code, reason = "records as a library of another version would hand them over")]

use core::ptr::{null, null_mut};
use hal_abi::{ArgSpec, ArgValue, FunctSpec, List, Record, Status, Str, Ticket, TicketState, size};

/// A record of a later minor version, with a field appended.
#[repr(C)]
struct Later<T> {
    known: T,
    more: [u64; 4],
}

#[test]
fn a_record_that_has_grown_reads_as_far_as_it_is_known() {
    let mut later = Later { known: ArgSpec::new(2, "name", "doc"), more: [u64::MAX; 4] };
    later.known.size = size::<Later<ArgSpec>>();
    // SAFETY: a live record with its true size.
    let read = unsafe { ArgSpec::read(&raw const later.known) };
    let read = read.map(|r| (r.kind, r.size == size::<Later<ArgSpec>>(), r.required));
    assert_eq!((read, later.more), (Some((2, true, 0)), [u64::MAX; 4]));
}

#[test]
fn a_record_that_is_no_record_is_refused() {
    let good = ArgSpec::new(1, "name", "doc");
    let least = u32::try_from(ArgSpec::MIN).unwrap_or(0);
    for size in [0, 1, 4, 8, least - 1] {
        let cut = ArgSpec { size, ..good };
        // SAFETY: the record is live and longer than its stated size.
        assert!(unsafe { ArgSpec::read(&raw const cut) }.is_none(), "{size} bytes");
    }
    let bounded = good.within(1.0, 2.0);
    let old = ArgSpec { size: least, ..bounded };
    // SAFETY: as above.
    let read = unsafe { ArgSpec::read(&raw const old) };
    assert!(read.is_some_and(|old| old.allows(3.0) && !bounded.allows(3.0)), "no range is stated");
    // SAFETY: null is allowed.
    assert!(unsafe { ArgSpec::read(null()) }.is_none());
    let odd = (&raw const good).cast::<u8>().wrapping_add(1).cast::<ArgSpec>();
    // SAFETY: a misaligned pointer is refused before it is read.
    assert!(unsafe { ArgSpec::read(odd) }.is_none(), "not aligned");
}

#[test]
fn an_absent_tail_reads_as_zero() {
    /// A record that has grown. The ABI's own records without appended fields cannot show this.
    #[repr(C)]
    #[derive(Clone, Copy)]
    struct Grown {
        size: u32,
        old: u32,
        new: Option<extern "C" fn()>,
        newest: u64,
    }
    // SAFETY: `#[repr(C)]`, size first, zero is valid.
    unsafe impl Record for Grown {
        const MIN: usize = 8;
    }
    #[repr(C, align(8))]
    struct Old {
        size: u32,
        old: u32,
    }
    let old = Old { size: 8, old: 7 };
    // SAFETY: a live record with its true size.
    let read = unsafe { Grown::read((&raw const old).cast()) };
    assert!(read.is_some_and(|g| (g.size, g.old, g.newest) == (8, 7, 0) && g.new.is_none()));
    assert_eq!(old.old, 7);
}

#[test]
fn lists_end_where_they_end() {
    static ONE: ArgSpec = ArgSpec::new(1, "one", "");
    static TWO: ArgSpec = ArgSpec::new(2, "two", "");
    static BOTH: [&ArgSpec; 2] = [&ONE, &TWO];
    let list = List::new(&BOTH);
    // SAFETY: static records.
    let kind = |i| unsafe { list.get(i) }.map(|a| a.kind);
    assert_eq!([kind(0), kind(1), kind(2), kind(usize::MAX)], [Some(1), Some(2), None, None]);
    let none = List::<ArgSpec>::EMPTY;
    assert!(none.is_empty());
    // SAFETY: nothing is read.
    assert!(unsafe { none.at(0) }.is_null());
}

#[test]
fn texts_are_text_or_refused() {
    // SAFETY: static and absent strings.
    let text = |s: Str| unsafe { s.get::<'static>() };
    assert_eq!(text(Str::new("größe")), Some("größe"));
    assert_eq!((text(Str::NONE), text(Str::new(""))), (Some(""), Some("")));
    assert!(!Status::EFAULT.is_ok() && Status::OK.is_ok() && Status(3).is_ok());
    assert_eq!(ArgValue::NONE.given, 0);
    let spec = FunctSpec {
        size: size::<FunctSpec>(),
        flags: 0,
        name: Str::NONE,
        doc: Str::NONE,
        run: None,
        state: null_mut(),
        free: None,
        uses: null(),
        n_uses: 0,
    };
    // SAFETY: a live record with its true size.
    assert!(unsafe { FunctSpec::read(&raw const spec) }.is_some_and(|s| s.run.is_none()));
}

#[test]
fn a_ticket_says_how_far_a_command_is() {
    let ticket = Ticket::new();
    assert_eq!(ticket.state(), TicketState::Pending);
    ticket.fail("joint 0 is on its limit");
    assert_eq!(ticket.state(), TicketState::Failed("joint 0 is on its limit"));
    assert_eq!(ticket.numbers(), ([0.0; 4], 0));
    let ticket = Ticket::new();
    ticket.fail_with("joint {} is at {}", &[2.0, -1.5]);
    assert_eq!(ticket.state(), TicketState::Failed("joint {} is at {}"));
    assert_eq!(ticket.numbers(), ([2.0, -1.5, 0.0, 0.0], 2));
    // More numbers than the ticket can hold are dropped.
    let ticket = Ticket::new();
    ticket.fail_with("", &[1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(ticket.numbers(), ([1.0, 2.0, 3.0, 4.0], 4));
    let ticket = Ticket::new();
    ticket.done();
    assert_eq!(ticket.state(), TicketState::Done);
}
