//! Each program's calls and error, against its file in `tests/golden`.

use std::fmt::Write as _;

use crate::support::{World, folder, run};

#[test]
fn programs_give_their_golden_calls() {
    let world = World::new();
    let mut wrong = Vec::new();
    assert!(world.files.len() >= 300, "only {} programs", world.files.len());
    for name in world.files.keys().filter(|n| !n.starts_with("lib-")) {
        let (calls, error) = run(name, &world);
        let mut text = String::new();
        for issued in &calls {
            writeln!(text, "{}: {}", issued.line, issued.call).unwrap();
        }
        if let Some(error) = error {
            writeln!(text, "error: {error}").unwrap();
        }
        let path = folder("golden").join(format!("{name}.canon"));
        wrong.extend(hal_golden::compare(&path, &text).err());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
