//! Where an instance's socket is.

use std::{
    env,
    path::{Path, PathBuf},
};

/// An instance of the engine: a name, and the files that go with it in the user's runtime folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    name: String,
    folder: PathBuf,
}

impl Place {
    /// The instance that is asked for: `name`, or `HAL_INSTANCE`, or `default`.
    ///
    /// # Errors
    /// The name is not usable.
    pub fn find(name: Option<&str>) -> Result<Self, String> {
        let name = name.map(str::to_owned).or_else(|| env::var("HAL_INSTANCE").ok());
        let name = name.filter(|n| !n.is_empty()).unwrap_or_else(|| "default".to_owned());
        let uid = rustix::process::getuid().as_raw();
        let runtime = env::var_os("HAL_RUNTIME_DIR")
            .or_else(|| env::var_os("XDG_RUNTIME_DIR"))
            .map(PathBuf::from)
            .filter(|p| p.is_absolute() && p.is_dir());
        let folder = runtime
            .map_or_else(|| env::temp_dir().join(format!("ferrule-{uid}")), |r| r.join("ferrule"));
        Self::at(folder, &name)
    }

    /// The instance of this name whose files are in `folder`, whatever the environment says.
    ///
    /// # Errors
    /// The name is not usable.
    pub fn at(folder: impl Into<PathBuf>, name: &str) -> Result<Self, String> {
        if !valid_instance(name) {
            return Err(format!(
                "instance name '{name}' is not usable: letters, digits, '-' and '_', at most 32"
            ));
        }
        Ok(Self { name: name.to_owned(), folder: folder.into() })
    }

    /// The instance's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The folder, mode 0700, of all of this user's instances.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The socket.
    #[must_use]
    pub fn socket(&self) -> PathBuf {
        self.folder.join(format!("{}.sock", self.name))
    }

    /// The file whose lock says that the instance is alive.
    #[must_use]
    pub fn lock(&self) -> PathBuf {
        self.folder.join(format!("{}.lock", self.name))
    }
}

/// Whether a name can be an instance's.
#[must_use]
pub fn valid_instance(name: &str) -> bool {
    !name.is_empty()
        && name.len() <= 32
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
}
