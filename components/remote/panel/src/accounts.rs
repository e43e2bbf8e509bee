//! Accounts: who may sign in with a password, and with which role.

use crate::session::Role;
use argon2::{
    Argon2,
    password_hash::{PasswordHash, PasswordHasher as _, PasswordVerifier as _, SaltString},
};
use clap::ValueEnum as _;
use std::{
    collections::BTreeMap, fs, io, os::unix::fs::PermissionsExt as _, path::Path, sync::Mutex,
    time::Duration,
};
use tokio::time::Instant;

/// Longest name of a user in bytes.
const MAX_NAME: usize = 64;
/// Shortest password in characters.
const MIN_PASSWORD: usize = 10;
/// Longest password in bytes.
const MAX_PASSWORD: usize = 1024;
/// Number of passwords that are tried in each span of time, by all who sign in together.
const MAX_TRIES: u32 = 10;
const SPAN: Duration = Duration::from_secs(10);

#[derive(Clone, Debug, PartialEq, Eq)]
struct Account {
    role: Role,
    /// Hash of the password, as argon2 writes it.
    hash: String,
}

/// All accounts.
#[derive(Debug)]
pub(crate) struct Accounts {
    list: BTreeMap<String, Account>,
    /// Hash of no password: an unknown user takes as long as a wrong password.
    nobody: String,
    /// Kept while a password is tried: one after the other.
    tries: Mutex<Tries>,
}

/// Passwords that were tried since a moment.
#[derive(Debug, Default)]
struct Tries {
    since: Option<Instant>,
    count: u32,
}

/// Refusal of a password.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wrong {
    /// The user is unknown, or the password is not theirs.
    Login,
    /// Too many passwords have been tried.
    Haste,
}

impl Accounts {
    /// Reads a file of lines `NAME ROLE HASH`.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let file = path.display();
        let fail = |e: io::Error| format!("{file}: {}", hal_output::reason(&e));
        let mode = fs::metadata(path).map_err(fail)?.permissions().mode();
        if mode & 0o077 != 0 {
            return Err(format!("{file}: others than its owner may use it: chmod 600"));
        }
        let text = fs::read_to_string(path).map_err(fail)?;
        let list = parse(&text).map_err(|(line, why)| format!("{file}:{line}: {why}"))?;
        if list.is_empty() {
            return Err(format!("{file}: it has no account: halpanel --add-account NAME=ROLE"));
        }
        Ok(Self { list, nobody: hash("nobody has this password")?, tries: Mutex::default() })
    }

    /// Returns whether there is an account of this name.
    pub(crate) fn has(&self, user: &str) -> bool {
        self.list.contains_key(user)
    }

    /// Returns the role of who signs in. This takes a while.
    pub(crate) fn check(&self, user: &str, password: &str) -> Result<Role, Wrong> {
        let mut tries = self.tries.lock().map_err(|_| Wrong::Haste)?;
        if !tries.permit(Instant::now()) {
            return Err(Wrong::Haste);
        }
        let account = self.list.get(user);
        let stored = account.map_or(&self.nobody, |account| &account.hash);
        let stored = PasswordHash::new(stored).map_err(|_| Wrong::Login)?;
        let short = password.len() <= MAX_PASSWORD;
        let fits = short && Argon2::default().verify_password(password.as_bytes(), &stored).is_ok();
        drop(tries);
        account.filter(|_| fits).map(|account| account.role).ok_or(Wrong::Login)
    }
}

impl Tries {
    /// Counts a try, and returns whether it is one of those permitted.
    fn permit(&mut self, now: Instant) -> bool {
        if self.since.is_none_or(|since| now - since > SPAN) {
            *self = Self { since: Some(now), count: 0 };
        }
        self.count += 1;
        self.count <= MAX_TRIES
    }
}

/// Returns the accounts of a text, or the line that is none, with the reason.
fn parse(text: &str) -> Result<BTreeMap<String, Account>, (usize, String)> {
    let mut list = BTreeMap::new();
    for (n, line) in (1..).zip(text.lines()) {
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let fail = |why: &str| Err((n, format!("{why}, must be NAME ROLE HASH")));
        let words: Vec<_> = line.split_whitespace().collect();
        let [name, role, hash] = *words else { return fail("this is no account") };
        if !is_name(name) {
            return fail("this is no name of a user");
        }
        let Ok(role) = Role::from_str(role, false) else {
            return fail("the role is none of viewer, operator, integrator");
        };
        if !PasswordHash::new(hash).is_ok_and(|hash| hash.hash.is_some()) {
            return fail("the hash is none of argon2");
        }
        let account = Account { role, hash: hash.to_owned() };
        if list.insert(name.to_owned(), account).is_some() {
            return fail("this user has another line");
        }
    }
    Ok(list)
}

fn is_name(name: &str) -> bool {
    let usual = |c: char| c.is_alphanumeric() || "._-@".contains(c);
    !name.is_empty() && name.len() <= MAX_NAME && name.chars().all(usual)
}

fn hash(password: &str) -> Result<String, String> {
    let mut salt = [0; 16];
    getrandom::fill(&mut salt).map_err(|e| format!("the system has no random numbers: {e}"))?;
    let fail = |e: argon2::password_hash::Error| format!("the password cannot be hashed: {e}");
    let salt = SaltString::encode_b64(&salt).map_err(fail)?;
    let hash = Argon2::default().hash_password(password.as_bytes(), &salt).map_err(fail)?;
    Ok(hash.to_string())
}

/// Adds an account `NAME=ROLE` to the file, or replaces it; the password is the first line of `input`.
pub(crate) fn add(path: &Path, account: &str, input: &mut impl io::BufRead) -> Result<(), String> {
    let (name, role) = account
        .split_once('=')
        .ok_or_else(|| format!("'{account}' is no account, must be NAME=ROLE"))?;
    let role = Role::from_str(role, false)
        .map_err(|_| format!("the role is '{role}', must be viewer, operator or integrator"))?;
    if !is_name(name) {
        return Err(format!("'{name}' is no name of a user: letters, digits, '.', '_', '-', '@'"));
    }
    let mut password = String::new();
    input.read_line(&mut password).map_err(|e| hal_output::reason(&e))?;
    let password = password.trim_end_matches(['\n', '\r']);
    if password.chars().count() < MIN_PASSWORD || password.len() > MAX_PASSWORD {
        return Err(format!("a password has {MIN_PASSWORD} characters at least"));
    }
    let file = path.display();
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(e) if e.kind() == io::ErrorKind::NotFound => String::new(),
        Err(e) => return Err(format!("{file}: {}", hal_output::reason(&e))),
    };
    parse(&text).map_err(|(line, why)| format!("{file}:{line}: {why}"))?;
    let others = text.lines().filter(|line| line.split_whitespace().next() != Some(name));
    let role = role.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default();
    let mut text: String = others.map(|line| format!("{line}\n")).collect();
    text.push_str(&format!("{name} {role} {}\n", hash(password)?));
    hal_output::install(path, text.as_bytes(), 0o600)
        .map_err(|e| format!("{file}: {}", hal_output::reason(&e)))
}

#[cfg(test)]
mod tests {
    //! Files of accounts, and passwords.

    use super::{Accounts, Instant, MAX_TRIES, Role, SPAN, Tries, Wrong, add, hash, parse};
    use std::{fs, os::unix::fs::PermissionsExt as _};

    #[test]
    fn a_file_that_is_damaged_is_refused_with_the_line() {
        let good = hash("correct horse").unwrap();
        assert_eq!(parse(&format!("# people\n\nana operator {good}\n")).unwrap().len(), 1);
        for (text, line, why) in [
            ("ana operator", 1, "this is no account"),
            (&*format!("ana operator {good} more"), 1, "this is no account"),
            (&*format!("\nana king {good}"), 2, "the role is none"),
            ("ana operator $argon2id$v=19$", 1, "the hash is none"),
            ("ana operator password", 1, "the hash is none"),
            (&*format!("a/b operator {good}"), 1, "this is no name"),
            (&*format!("ana viewer {good}\nana operator {good}"), 2, "this user has another"),
        ] {
            let (at, said) = parse(text).unwrap_err();
            assert!(at == line && said.starts_with(why), "{text}: {at}: {said}");
        }
    }

    #[test]
    fn passwords_are_not_tried_in_haste() {
        let (mut tries, now) = (Tries::default(), Instant::now());
        assert!((0..MAX_TRIES).all(|_| tries.permit(now)) && !tries.permit(now + SPAN));
        assert!(tries.permit(now + SPAN + SPAN) && tries.permit(now + SPAN + SPAN));
    }

    #[test]
    fn an_account_is_made_kept_and_checked() {
        let folder = std::env::temp_dir().join(format!("halpanel-accounts-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("accounts");
        for (account, password) in [
            ("ana", "long enough\n"),
            ("ana=king", "long enough\n"),
            ("a b=viewer", "long enough\n"),
            ("ana=viewer", "short\n"),
        ] {
            add(&file, account, &mut password.as_bytes()).unwrap_err();
            assert!(!file.exists(), "{account}");
        }
        add(&file, "ana=viewer", &mut &b"the first password\n"[..]).unwrap();
        add(&file, "eva=integrator", &mut &b"another password\n"[..]).unwrap();
        add(&file, "ana=operator", &mut &b"correct horse\n"[..]).unwrap();
        let accounts = Accounts::read(&file).unwrap();
        for (user, password, role) in [
            ("ana", "correct horse", Ok(Role::Operator)),
            ("eva", "another password", Ok(Role::Integrator)),
            ("ana", "the first password", Err(Wrong::Login)),
            ("ana", "", Err(Wrong::Login)),
            ("nobody", "nobody has this password", Err(Wrong::Login)),
        ] {
            assert_eq!(accounts.check(user, password), role, "{user} {password}");
        }
        fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
        assert!(Accounts::read(&file).unwrap_err().contains("chmod 600"));
        fs::remove_dir_all(&folder).unwrap();
    }
}
