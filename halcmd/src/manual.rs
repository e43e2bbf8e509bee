//! The manual page of halcmd, from the tables of commands and options.

pub mod complete;
pub mod explain;
pub mod help;
pub mod man;
pub(crate) mod wrap;

use crate::{
    language::rows::GROUPS,
    language::table::{Row, line},
    manual::wrap::sentence,
    programs::halcmd,
    programs::options::Opt,
};

/// Returns the page in the format of `man`.
#[must_use]
pub fn page() -> String {
    let mut text = String::from(concat!(
        ".\\\" Made from the table of commands; a test says whether it is true.\n",
        ".TH HALCMD 1 \"\" Ferrule \"Ferrule\"\n",
        ".SH NAME\nhalcmd \\- gives commands to a running machine\n",
        ".SH SYNOPSIS\n",
        ".B halcmd\n[\\fIoptions\\fR] [\\fIcommand\\fR [\\fIarguments\\fR]]\n.br\n",
        ".B halcmd\n[\\fIoptions\\fR] \\fB\\-f\\fR [\\fIfile\\fR]\n",
        ".SH DESCRIPTION\n",
        "halcmd gives commands of the .hal language to an instance that halrun has made: one from\n",
        "the command line, or those of a file or of standard input. On a terminal,\n",
        ".B halcmd \\-kf\n",
        "is a prompt with history (Ctrl-R searches it) and completion (Tab). The words of the\n",
        "command line are taken as they are; in files, $NAME and [SECTION]NAME are replaced.\n",
        ".SH OPTIONS\n",
    ));
    halcmd::completable().iter().for_each(|option| text.push_str(&option_text(option)));
    text.push_str(".SH COMMANDS\n");
    for (title, rows) in GROUPS {
        text.push_str(&format!(".SS {}\n", escaped(title)));
        rows.iter().for_each(|row| text.push_str(&command_text(row)));
    }
    text.push_str(concat!(
        ".SS Commands of components\n.TP\n",
        ".B COMPONENT.VERB NAME=VALUE...\n",
        "What a component offers; the command \\fBcommands\\fR lists it. With \\-\\-wait, the line\n",
        "ends when the machine has carried it out.\n",
        ".SH EXIT STATUS\n",
        "0: every command succeeded. 1: one failed. 255: an option is wrong, or the file cannot be\n",
        "opened.\n",
        ".SH ENVIRONMENT\n",
        ".TP\n.B HAL_INSTANCE\nThe instance, as \\-\\-instance names it.\n",
        ".TP\n.B NO_COLOR\nSet: nothing is coloured.\n",
        ".TP\n.B XDG_STATE_HOME\n",
        "Where ferrule/history keeps what was typed at prompts; ~/.local/state if not set.\n",
    ));
    text
}

fn option_text(option: &Opt<()>) -> String {
    let names = [option.short.map(|c| format!("-{c}")), option.long.map(|l| format!("--{l}"))];
    let names: Vec<String> = names.into_iter().flatten().map(|n| escaped(&n)).collect();
    let value = option.value.map(|v| format!(" \\fI{v}\\fR")).unwrap_or_default();
    let help = escaped(&sentence(option.help));
    format!(".TP\n\\fB{}\\fR{value}\n{help}\n", names.join("\\fR, \\fB"))
}

fn command_text(row: &Row) -> String {
    let mut text = format!(".TP\n\\fB{}\\fR\n", escaped(&line(row)));
    text.push_str(&format!("{}\n", escaped(&sentence(row.summary))));
    if !row.help.is_empty() {
        text.push_str(&format!("{}\n", escaped(row.help)));
    }
    if !row.examples.is_empty() {
        text.push_str(".RS\n.PP\n.nf\n");
        row.examples.iter().for_each(|e| text.push_str(&format!("    {}\n", escaped(e))));
        text.push_str(".fi\n.RE\n");
    }
    text
}

/// Escapes a text so that the formatter prints it unchanged.
pub(crate) fn escaped(text: &str) -> String {
    let escaped = text.replace('\\', "\\e").replace('-', "\\-");
    let special = escaped.starts_with(['.', '\'']);
    if special { format!("\\&{escaped}") } else { escaped }
}

#[cfg(test)]
mod tests {
    use super::page;

    #[test]
    fn the_page_is_true() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/halcmd.1");
        hal_golden::check(file.as_ref(), &page());
    }
}
