//! The notes of `halcmd check` that ask for nothing here, each with its reason at its line.

use super::{answers::Answers, lines::line, timing::timing};
use crate::{
    check::{Checked, check},
    programs::{halrun::folders::plugin_path, profile::Profile},
};
use hal_protocol::{Code, Finding, Level};
use std::{collections::BTreeMap, path::Path};

/// Returns why a note asks for nothing in this machine; nothing if it does.
fn reason(answers: &Answers, finding: &Finding) -> Option<&'static str> {
    let code = finding.code.to_string();
    match code.as_str() {
        "H308" => Some("what the machine does not have"),
        // An output of the answers that nothing feeds would be a fault of these files.
        "H310" => (!is_answered(answers, &finding.subject)).then_some("free outputs"),
        "H318" => {
            let is_wired = answers.joint.iter().all(|j| j.step.is_some());
            (!is_wired).then_some("a motor that is not wired")
        }
        "H312" => answers.pins.charge_pump.is_none().then_some("the board has no charge pump"),
        "H509" => Some("the control loop"),
        // The timing leaves half of the periods without a step at the joint's velocity.
        "H602" => timing(answers)
            .is_ok_and(|timing| !timing.resets && timing.space == 0)
            .then_some("each step ends before the next begins"),
        "H510" => Some("a value may be a cycle old"),
        _ => None,
    }
}

/// Returns whether an output is a line of the answers.
fn is_answered(answers: &Answers, pin: &str) -> bool {
    let pins = &answers.pins;
    let whole = [
        &pins.estop_out,
        &pins.charge_pump,
        &pins.enable,
        &pins.spindle,
        &pins.spindle_reverse,
        &pins.spindle_pwm,
    ];
    let joints = answers.joint.iter().flat_map(|j| [&j.step, &j.direction, &j.enable]);
    let lines = whole.into_iter().chain(joints).flatten().filter_map(|text| line(text));
    lines.into_iter().any(|line| {
        let end = format!("pin-{:02}-out", line.number);
        pin.ends_with(&end)
            && (pin.starts_with("viagpio") || pin.starts_with(&format!("parport.{}.", line.port)))
    })
}

/// Checks the machine of an INI file.
pub(super) fn notes(ini: &Path) -> Result<Checked, String> {
    let profile = Profile::of_environment().map_err(|e| e.to_string())?;
    let plugins = plugin_path(&|name| profile.system(name));
    Ok(check(&[ini.to_string_lossy().into_owned()], None, plugins))
}

/// Returns the texts of files with comments that allow the notes which ask for nothing. Other findings stay.
pub(super) fn allowed(
    answers: &Answers,
    found: &Checked,
    folder: &Path,
    files: &[(String, String)],
) -> Vec<(String, String)> {
    type Lines = BTreeMap<u32, BTreeMap<Code, &'static str>>;
    let mut places: BTreeMap<String, Lines> = BTreeMap::new();
    for finding in found.findings.iter().filter(|f| f.level < Level::Error) {
        let (Some(at), Some(why)) = (&finding.at, reason(answers, finding)) else { continue };
        let file = Path::new(&*at.file);
        let name = file.strip_prefix(folder).unwrap_or(file).to_string_lossy().into_owned();
        places.entry(name).or_default().entry(at.line).or_default().insert(finding.code, why);
    }
    let with_comments = |(name, text): &(String, String)| {
        let Some(lines) = places.get(name) else { return (name.clone(), text.clone()) };
        let mut to = String::new();
        for (n, line) in (1..).zip(text.lines()) {
            for (code, why) in lines.get(&n).into_iter().flatten() {
                to.push_str(&format!("# check: allow {code} {why}\n"));
            }
            to.push_str(line);
            to.push('\n');
        }
        (name.clone(), to)
    };
    files.iter().map(with_comments).collect()
}
