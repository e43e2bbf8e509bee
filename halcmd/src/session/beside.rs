//! Sources of components beside the script, for the error of a component that nothing offers.

use hal_protocol::{Code, Failure, Request};
use std::path::{Path, PathBuf};

/// Endings of the sources that `halcompile` compiles.
const ENDINGS: [&str; 2] = ["comp", "c"];

/// Returns the component that a request loads.
pub(super) fn module_of(request: &Request) -> Option<String> {
    match request {
        Request::Load { module, .. } | Request::LoadForeign { module, .. } => Some(module.clone()),
        _ => None,
    }
}

/// Adds to the failure of a load that a source of the component's name lies beside the script or the INI file. `found`
/// returns where a file of the script is.
pub(super) fn name_source(
    mut failure: Failure,
    module: &str,
    (script, ini): (&str, Option<&str>),
    found: impl Fn(&str) -> PathBuf,
) -> Failure {
    let is_missing = failure.finding == Some(Code::NoComponent)
        || failure.text.contains("no component in C of this name");
    if !is_missing || module.is_empty() || module.contains(['/', '\0']) {
        return failure;
    }
    for (file, place) in [(Some(script), "the script"), (ini, "the INI file")] {
        let Some(folder) = file.and_then(|file| Path::new(file).parent()) else { continue };
        let sources = ENDINGS.map(|ending| folder.join(format!("{module}.{ending}")));
        if let Some(source) = sources.iter().find(|s| found(&s.to_string_lossy()).is_file()) {
            let name = source.file_name().unwrap_or_default().to_string_lossy();
            failure.hint = Some(format!(
                "{name} lies beside {place}: compile it with `halcompile --install {}`",
                source.display()
            ));
            break;
        }
    }
    failure
}
