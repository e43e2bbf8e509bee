//! Names of cards.

/// Names that were given so far.
#[derive(Debug, Default)]
pub(crate) struct Names(Vec<String>);

impl Names {
    /// Returns the name of the next card of a board, such as `hm2_7i92.0`: the cards of a kind are counted from 0.
    pub(crate) fn next(&mut self, board: &str) -> String {
        let kind = kind(board);
        let number = self.0.iter().filter(|name| **name == kind).count();
        let name = format!("hm2_{kind}.{number}");
        self.0.push(kind);
        name
    }
}

/// Returns the kind of a board: small letters and digits up to a dash, and one name for boards that differ in their
/// connectors alone.
pub(crate) fn kind(board: &str) -> String {
    let whole = board.split('-').next().unwrap_or_default();
    let kind: String = whole
        .chars()
        .filter(char::is_ascii_alphanumeric)
        .map(|c| c.to_ascii_lowercase())
        .take(16)
        .collect();
    match kind.as_str() {
        "7i80db" | "7i80hd" | "7i80hdt" => "7i80".to_owned(),
        "7i76eu" => "7i76".to_owned(),
        "7i92t" | "7i95t" | "7i97t" => kind.trim_end_matches('t').to_owned(),
        "" => "card".to_owned(),
        _ => kind,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cards_of_a_kind_are_counted() {
        let mut names = Names::default();
        let boards = ["7I92", "7I76E-16", "7I92", "7I80HD-25", "7I80DB-16", "", "LITEHM2", "7I95T"];
        assert_eq!(
            boards.map(|board| names.next(board)),
            [
                "hm2_7i92.0",
                "hm2_7i76e.0",
                "hm2_7i92.1",
                "hm2_7i80.0",
                "hm2_7i80.1",
                "hm2_card.0",
                "hm2_litehm2.0",
                "hm2_7i95.0"
            ]
        );
    }
}
