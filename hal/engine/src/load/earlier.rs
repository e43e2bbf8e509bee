//! First values of items in LinuxCNC 2.9, where they differ from those of 2.10, which are ours.

use hal_protocol::Value;

/// An item of a component whose first value differs between the versions.
#[derive(Debug)]
pub(crate) struct Earlier {
    /// Name of the component.
    pub(crate) component: &'static str,
    /// Last part of the item's name.
    pub(crate) item: &'static str,
    /// Value in 2.9. An item that 2.9 does not have gets the value with which the component behaves as there.
    pub(crate) value: Value,
}

/// All such items.
pub(crate) const ROWS: [Earlier; 6] = [
    row("carousel", "width", Value::S32(0)),
    row("limit3", "maxa", Value::Float(1e20)),
    row("ohmic", "ohmic-low", Value::Float(5.0)),
    row("ohmic", "ohmic-threshold", Value::Float(18.0)),
    row("toggle2nist", "debounce", Value::U32(0)),
    row("toggle2nist", "max-pulse-length", Value::U32(u32::MAX)),
];

const fn row(component: &'static str, item: &'static str, value: Value) -> Earlier {
    Earlier { component, item, value }
}

/// Returns the value of 2.9 of an item, if it differs. `component` is the name of a load, such as `limit3` or `limit3:2`.
pub(crate) fn value(component: &str, item: &str) -> Option<Value> {
    let module = component.split_once(':').map_or(component, |(module, _)| module);
    let last = item.rsplit('.').next().unwrap_or_default();
    ROWS.iter().find(|row| row.component == module && row.item == last).map(|row| row.value)
}

#[cfg(test)]
mod tests {
    use super::{ROWS, value};
    use hal_protocol::Value;

    #[test]
    fn items_are_found_by_component_and_last_part() {
        assert_eq!(value("limit3:2", "left.maxa"), Some(Value::Float(1e20)));
        assert_eq!(value("limit2", "limit2.0.maxa"), None);
        assert_eq!(value("limit3", "limit3.0.maxv"), None);
    }

    #[test]
    fn the_page_for_users_of_linuxcnc_has_all_rows() {
        let page = include_str!("../../../../halcmd/LINUXCNC.md");
        for row in &ROWS {
            let begin = format!("| `{}.0.{}` | {} |", row.component, row.item, row.value);
            assert!(page.contains(&begin), "{begin}");
        }
    }
}
