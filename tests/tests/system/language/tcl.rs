//! Every folder of `tests/tcl`: Tcl files as HAL files, the program haltcl, two passes, and what `check` says of Tcl files.

use hal_tests::{
    case::{Case, cases_in, for_each},
    tools::{Tool, tclsh},
};

#[test]
fn tcl_files_do_what_is_expected() {
    if Tool::of("tclsh").or_skip(tclsh()).is_none() {
        return;
    }
    let cases = cases_in("tests/tcl");
    assert!(!cases.is_empty(), "no case of this name");
    for_each(&cases, Case::check);
}
