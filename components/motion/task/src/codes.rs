//! The G codes in force as a text.

use hal_gcode::State;

/// Returns the G codes in force as a text.
pub(crate) fn text(state: &State) -> String {
    joined(&state.g_codes())
}

/// Returns codes, times ten, as a text.
pub(crate) fn joined(codes: &[u32]) -> String {
    codes.iter().map(|code| code_text(*code)).collect::<Vec<_>>().join(" ")
}

fn code_text(code: u32) -> String {
    match (code / 10, code % 10) {
        (whole, 0) => format!("G{whole}"),
        (whole, tenth) => format!("G{whole}.{tenth}"),
    }
}
