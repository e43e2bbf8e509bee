//! Name of an instance and location of its files.

use std::{
    env,
    ffi::OsString,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

/// Name of the subfolder in the system's folder for runtime files.
const FOLDER: &str = "ferrule";

/// An instance of the engine: a name, and the folder of its files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    name: String,
    folder: PathBuf,
    named: bool,
}

impl Place {
    /// Returns the instance `name`; without a name, the one in `HAL_INSTANCE`, or `default`.
    ///
    /// The files are in the subfolder `ferrule` of the first of these folders:
    /// - `HAL_RUNTIME_DIR`;
    /// - `XDG_RUNTIME_DIR`, then `/run/user/UID`, if it belongs to this user and nobody else can
    ///   write there (a folder that `sudo` passed on belongs to another user and is skipped);
    /// - for root, `/run`.
    ///
    /// If there is none, they are in `ferrule-UID` in the folder for temporary files. Another user
    /// can create a folder of that name first; [`crate::Folder`] then refuses to use it.
    ///
    /// # Errors
    /// The name is not a valid instance name.
    pub fn find(name: Option<&str>) -> Result<Self, String> {
        let name = name.map(str::to_owned).or_else(|| env::var("HAL_INSTANCE").ok());
        let name = name.filter(|n| !n.is_empty()).unwrap_or_else(|| "default".to_owned());
        let user = rustix::process::geteuid().as_raw();
        let (folder, named) = folder(user, &|name| env::var_os(name), Path::new("/"));
        Ok(Self { named, ..Self::at(folder, &name)? })
    }

    /// Returns the instance of this name whose files are in `folder`. Ignores the environment.
    ///
    /// # Errors
    /// The name is not a valid instance name.
    pub fn at(folder: impl Into<PathBuf>, name: &str) -> Result<Self, String> {
        if !valid_instance(name) {
            return Err(format!(
                "instance name '{name}' is not usable: letters, digits, '-' and '_', at most 32"
            ));
        }
        Ok(Self { name: name.to_owned(), folder: folder.into(), named: true })
    }

    /// Returns the name of the instance.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the folder of all of this user's instances. The engine creates it with mode 0700.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns whether the folder was named explicitly instead of chosen by the rules of
    /// [`Self::find`]. Root may then use an instance of the user who owns the folder.
    #[must_use]
    pub const fn is_named(&self) -> bool {
        self.named
    }

    /// Returns the path of the socket.
    #[must_use]
    pub fn socket(&self) -> PathBuf {
        self.folder.join(self.socket_name())
    }

    /// Returns the path of the lock file. A running engine holds a lock on it.
    #[must_use]
    pub fn lock(&self) -> PathBuf {
        self.folder.join(self.lock_name())
    }

    /// Returns the path of the file with what an instance in the background has said.
    #[must_use]
    pub fn log(&self) -> PathBuf {
        self.folder.join(self.log_name())
    }

    pub(crate) fn log_name(&self) -> String {
        format!("{}.log", self.name)
    }

    pub(crate) fn socket_name(&self) -> String {
        format!("{}.sock", self.name)
    }

    pub(crate) fn lock_name(&self) -> String {
        format!("{}.lock", self.name)
    }
}

/// Returns the folder of a user's instances, and whether the environment names it explicitly.
fn folder(user: u32, variable: &dyn Fn(&str) -> Option<OsString>, root: &Path) -> (PathBuf, bool) {
    let named = |name: &str| variable(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    if let Some(folder) = named("HAL_RUNTIME_DIR") {
        return (std::path::absolute(&folder).unwrap_or(folder).join(FOLDER), true);
    }
    let session = named("XDG_RUNTIME_DIR").filter(|folder| folder.is_absolute());
    let user_folder = root.join(format!("run/user/{user}"));
    let run = (user == 0).then(|| root.join("run"));
    let mut kept = session.into_iter().chain([user_folder]).chain(run);
    match kept.find(|folder| belongs_to(user, folder)) {
        Some(folder) => (folder.join(FOLDER), false),
        None => {
            let temporary = named("TMPDIR").unwrap_or_else(|| root.join("tmp"));
            (temporary.join(format!("{FOLDER}-{user}")), false)
        }
    }
}

/// Returns whether this user owns the folder and nobody else can write to it.
fn belongs_to(user: u32, folder: &Path) -> bool {
    std::fs::metadata(folder).is_ok_and(|m| m.is_dir() && m.uid() == user && m.mode() & 0o022 == 0)
}

/// Returns whether `name` is a valid instance name.
#[must_use]
pub fn valid_instance(name: &str) -> bool {
    !name.is_empty()
        && name.len() <= 32
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{fs, os::unix::fs::PermissionsExt};

    #[test]
    fn the_folder_is_one_that_others_cannot_take_where_there_is_one() {
        let root = env::temp_dir().join(format!("hal-place-{}", std::process::id()));
        let me = rustix::process::geteuid().as_raw();
        let user = format!("run/user/{me}");
        for made in [&*user, "session", "open", "tmp", "mine"] {
            fs::create_dir_all(root.join(made)).unwrap();
            fs::set_permissions(root.join(made), fs::Permissions::from_mode(0o755)).unwrap();
        }
        fs::set_permissions(root.join("open"), fs::Permissions::from_mode(0o777)).unwrap();
        let check = |user: u32, variables: &[(&str, &str)], want: &str, named: bool| {
            let variable = |name: &str| {
                let found = variables.iter().find(|(n, _)| *n == name);
                found.map(|(_, value)| value.replace("ROOT", root.to_str().unwrap()).into())
            };
            let found = folder(user, &variable, &root);
            assert_eq!(found, (root.join(want), named), "{variables:?}");
        };
        let (own, session) = (format!("{user}/ferrule"), ("XDG_RUNTIME_DIR", "ROOT/session"));
        check(me, &[], &own, false);
        check(me, &[session], "session/ferrule", false);
        check(me, &[session, ("HAL_RUNTIME_DIR", "ROOT/mine")], "mine/ferrule", true);
        // A folder that is named is used whether it exists or not. An empty variable is ignored.
        check(me, &[("HAL_RUNTIME_DIR", "ROOT/new")], "new/ferrule", true);
        check(me, &[session, ("HAL_RUNTIME_DIR", "")], "session/ferrule", false);
        // A folder that does not exist, is not an absolute path, or can be written by others is
        // skipped.
        for passed in ["ROOT/none", "session", "", "ROOT/open"] {
            check(me, &[("XDG_RUNTIME_DIR", passed)], &own, false);
        }
        // A folder of another user, as `sudo -E` passes it on, is skipped too.
        let (other, fallback) = (me + 1, format!("tmp/ferrule-{}", me + 1));
        check(other, &[session], &fallback, false);
        check(other, &[session, ("TMPDIR", "ROOT/mine")], &format!("mine/ferrule-{other}"), false);
        // Root has a folder that exists without a login session.
        fs::remove_dir(root.join(&user)).unwrap();
        let without = if me == 0 { "run/ferrule" } else { &format!("tmp/ferrule-{me}") };
        check(me, &[], without, false);
        fs::remove_dir_all(root).unwrap();
    }

    #[test]
    fn names_of_instances_lead_nowhere_else() {
        let long = "x".repeat(33);
        for name in ["", ".", "..", "../x", "a/b", "/tmp/x", "a.b", "a b", "a\0", "\u{e4}", &long] {
            assert!(Place::at("/run", name).is_err(), "{name:?}");
        }
        let place = Place::at("/run/ferrule", "a-B_9").unwrap();
        assert_eq!(place.socket(), Path::new("/run/ferrule/a-B_9.sock"));
        assert_eq!(place.lock(), Path::new("/run/ferrule/a-B_9.lock"));
    }
}
