//! Mistakes of component authors are compile errors that suggest the correction.

#[test]
fn mistakes_are_explained() {
    trybuild::TestCases::new().compile_fail("tests/author/*.rs");
}
