//! What a library says is heard while the library is open. Alone in its process: nobody else may
//! keep the library open.

use hal_engine::ClockKind;
use hal_tests::machine::{Machine, says};

#[test]
fn what_a_library_says_is_heard_before_it_is_closed() {
    let mut m = Machine::new(ClockKind::Virtual);
    let refused = says(&mut m, "loadrt chatty fail=enough");
    assert!(refused.starts_with("chatty: enough; fail=: "), "{refused}");
    let said = m.engine.take_messages();
    assert_eq!(said, ["chatty: being created"]);
    m.script("loadrt threads\nloadrt chatty\naddf chatty thread1\nsetp chatty.times 2\nstart");
    m.script("run 1000000\ndelf chatty\nunloadrt chatty");
    let said = m.engine.take_messages();
    assert_eq!(
        said,
        [
            "chatty: being created",
            "chatty: being opened, 1 of 2.5",
            "chatty: said 1 times",
            "chatty: said 2 times",
            "chatty: being stopped"
        ]
    );
    m.script("loadrt chatty\naddf chatty thread1\nsetp chatty.times 5000\nrun 1000000");
    let said = m.engine.take_messages();
    assert_eq!(said.last().unwrap(), "904 messages of components were lost: too many at once");
}
