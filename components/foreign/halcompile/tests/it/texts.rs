//! Tests of the texts made from components: manual page, `AsciiDoc`, declaration in Rust, and C. `UPDATE_EXPECT=1`
//! rewrites the folder `expected`.

use std::{fs, path::Path};

#[test]
fn texts_are_as_expected() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let wanted: &[(&str, &[&str])] = &[
        ("told_well", &["9", "adoc", "rs"]),
        ("gated", &["9", "rs", "c"]),
        ("width_of", &["9", "rs"]),
        ("two_ways", &["rs"]),
        ("keeps", &["rs"]),
        ("own_main", &["9", "rs"]),
        ("new_rows", &["rs", "c"]),
    ];
    let mut wrong = Vec::new();
    for (name, endings) in wanted {
        let bytes = fs::read(here.join(format!("../../../tests/comp/{name}.comp"))).unwrap();
        let file = format!("{name}.comp");
        let (component, doubts) = halcompile::read(&file, &bytes).unwrap();
        assert!(doubts.faults().is_empty(), "{doubts}");
        for ending in *endings {
            let out = format!("{name}.c");
            let wanted = halcompile::c::Wanted { source: &file, out: &out, personalities: 64 };
            let text = match *ending {
                "9" => halcompile::document::roff(&component),
                "adoc" => halcompile::document::adoc(&component),
                "rs" => halcompile::rust::text(&component),
                _ => halcompile::c::text(&component, &wanted),
            };
            let path = here.join(format!("tests/expected/{name}.{ending}"));
            wrong.extend(hal_golden::compare(&path, &text).err());
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
