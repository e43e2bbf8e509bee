//! Mistakes by an author are compile errors that say what to write.

#[test]
fn mistakes_are_explained() {
    trybuild::TestCases::new().compile_fail("tests/author/*.rs");
}
