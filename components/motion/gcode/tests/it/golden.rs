//! Each program's calls and error, against its file in `tests/golden`.

use std::fmt::Write as _;

use crate::support::{World, folder, run};

#[test]
fn programs_give_their_golden_calls() {
    let world = World::new();
    let renew = std::env::var_os("UPDATE_EXPECT").is_some();
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
        if renew {
            std::fs::write(&path, &text).unwrap();
        }
        let golden = std::fs::read_to_string(&path).unwrap_or_default();
        if golden != text {
            let first = golden.lines().zip(text.lines()).find(|(a, b)| a != b);
            wrong.push(format!("{name}: {first:?}"));
        }
    }
    assert!(wrong.is_empty(), "renew with UPDATE_EXPECT=1 if meant:\n{}", wrong.join("\n"));
}
