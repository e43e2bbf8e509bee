//! The output of `list`.

use hal_protocol::Reply;

/// Writes the names in a reply, each followed by a space, then the end of the line.
#[must_use]
pub fn names(reply: &Reply) -> String {
    let names: Vec<&str> = match reply {
        Reply::Components(list) => list.iter().map(|x| x.name.as_str()).collect(),
        Reply::Items(list) => list.iter().map(|x| x.name.as_str()).collect(),
        Reply::Signals(list) => list.iter().map(|x| x.name.as_str()).collect(),
        Reply::Functs(list) => list.iter().map(|x| x.name.as_str()).collect(),
        Reply::Threads(list) => list.iter().map(|x| x.name.as_str()).collect(),
        Reply::Aliases(list) => list.iter().map(|x| x.alias.as_str()).collect(),
        Reply::Commands(list) => list.iter().map(|x| x.name.as_str()).collect(),
        Reply::Streams(list) => list.iter().map(|x| x.name.as_str()).collect(),
        Reply::Workers(list) => list.iter().map(|x| x.name.as_str()).collect(),
        Reply::Snapshots(list) => list.iter().map(|x| x.name.as_str()).collect(),
        Reply::Offers(list) => list.iter().map(|x| x.component.as_str()).collect(),
        _ => Vec::new(),
    };
    let mut text: String = names.iter().map(|n| format!("{n} ")).collect();
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use super::names;
    use crate::show::samples;
    use hal_protocol::Reply;

    #[test]
    fn each_name_is_followed_by_a_blank() {
        assert_eq!(names(&samples::threads()), "slow fast \n");
        assert_eq!(names(&samples::components()), "pwmgen halcmd20 not __fast threads \n");
        assert_eq!(names(&Reply::Items(Vec::new())), "\n");
    }
}
