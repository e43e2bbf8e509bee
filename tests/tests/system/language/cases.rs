//! Every folder of `tests/hal`, through the real halrun. `UPDATE_EXPECT=1` writes the expected output; `CASE=name` runs
//! the cases whose names begin with that text.

use hal_tests::case::{Case, cases, for_each};

#[test]
fn scripts_do_what_is_expected() {
    let cases = cases();
    assert!(!cases.is_empty(), "no case of this name");
    for_each(&cases, Case::check);
}
