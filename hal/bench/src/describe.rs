//! Descriptions of what a component declared, for tests that hold a document to them.

use super::{Bench, host::text};

/// An argument of a command, or a field of a snapshot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Described {
    /// Name.
    pub name: String,
    /// HAL type of a field, with the number of values if there are several; empty for an argument.
    pub ty: String,
    /// Description.
    pub doc: String,
}

impl core::fmt::Debug for Bench {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Bench").field("items", &self.names()).finish_non_exhaustive()
    }
}

#[expect(clippy::panic, reason = "a table for tests")]
impl Bench {
    /// Returns the names of all commands, sorted.
    #[must_use]
    pub fn commands(&self) -> Vec<String> {
        self.table.borrow().commands.keys().cloned().collect()
    }

    /// Returns the arguments of a command, in order.
    #[must_use]
    pub fn arguments(&self, command: &str) -> Vec<Described> {
        let table = self.table.borrow();
        let (args, _) =
            table.commands.get(command).unwrap_or_else(|| panic!("no command {command}"));
        let one = |a: &hal_component::abi::ArgSpec| Described {
            name: text(a.name),
            ty: String::new(),
            doc: text(a.doc),
        };
        args.iter().map(one).collect()
    }

    /// Returns the fields of a snapshot, in order.
    #[must_use]
    pub fn fields(&self, snapshot: &str) -> Vec<Described> {
        let types = ["?", "bit", "float", "s32", "u32", "port", "s64", "u64"];
        let table = self.table.borrow();
        let page =
            table.snapshots.get(snapshot).unwrap_or_else(|| panic!("no snapshot {snapshot}"));
        let one = |f: &hal_component::abi::FieldSpec| {
            let ty = types.get(usize::from(f.ty)).unwrap_or(&"?");
            let ty = if f.count == 1 { (*ty).to_owned() } else { format!("{ty} × {}", f.count) };
            Described { name: text(f.name), ty, doc: text(f.doc) }
        };
        page.fields.iter().map(one).collect()
    }
}
