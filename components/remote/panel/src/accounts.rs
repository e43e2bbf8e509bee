//! Accounts: who may sign in with a password, and with which role.

mod turn;

use crate::{
    limits::{Limits, SignInPlace},
    session::Role,
};
use argon2::{
    Argon2,
    password_hash::{PasswordHash, PasswordHasher as _, PasswordVerifier as _, SaltString},
};
use clap::ValueEnum as _;
use ring::hmac;
use std::{
    collections::BTreeMap,
    fmt, fs, io,
    os::unix::fs::PermissionsExt as _,
    path::Path,
    sync::{
        Mutex, MutexGuard, OnceLock, PoisonError,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
    time::Duration,
};
use tokio::time::Instant;
use turn::Turns;

/// Longest name of a user in bytes.
const MAX_NAME: usize = 64;
/// Shortest password in characters.
const MIN_PASSWORD: usize = 10;
/// Longest password in bytes.
const MAX_PASSWORD: usize = 1024;
/// Number of strangers whose passwords wait for their turn; more are refused at once.
const MAX_WAITING: usize = 4;
/// Wait of those that are refused so.
const FULL_WAIT: Duration = Duration::from_secs(1);
/// Number of devices that a browser keeps, and characters of one: its number and its mark.
const MAX_DEVICES: usize = 8;
const DEVICE: usize = 2 * DEVICE_NUMBER + 64;
/// Bytes of the number of a device.
const DEVICE_NUMBER: usize = 8;
/// Sign between two devices.
const BETWEEN: char = '~';

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
    /// Failures of late.
    limits: Mutex<Limits>,
    /// Turns in which passwords are tried: one after the other.
    turns: Turns,
    /// Number of strangers that wait for it.
    waiting: AtomicUsize,
}

/// Refusal of a password.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wrong {
    /// The user is unknown, or the password is not theirs.
    Login,
    /// Too many sign-ins from this place have failed, or too many are tried now: this time is to be waited.
    Haste(Duration),
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
        Ok(Self {
            list,
            nobody: nobody().map_err(|why| why.to_string())?,
            limits: Mutex::default(),
            turns: Turns::default(),
            waiting: AtomicUsize::new(0),
        })
    }

    /// Returns whether there is an account of this name.
    pub(crate) fn has(&self, user: &str) -> bool {
        self.list.contains_key(user)
    }

    /// Returns the role of who signs in. This takes a while.
    pub(crate) fn check(
        &self,
        user: &str,
        password: &str,
        source: &SignInPlace,
    ) -> Result<Role, Wrong> {
        // Names that no account can have are one: they need no memory.
        let account = if is_name(user) { user } else { "" };
        // Who has to wait is no part of the line of those that are tried.
        let begun = lock(&self.limits).begin(Instant::now(), source, account);
        begun.map_err(Wrong::Haste)?;
        let is_known = matches!(source, SignInPlace::Device(_));
        let waiting = (!is_known).then(|| Waiting::enter(&self.waiting));
        if waiting.as_ref().is_some_and(|waiting| waiting.before >= MAX_WAITING) {
            // Nothing was tried.
            lock(&self.limits).succeed(Instant::now(), source, account);
            return Err(Wrong::Haste(FULL_WAIT));
        }
        let turn = self.turns.take(is_known);
        let found = self.list.get(user);
        let stored = found.map_or(&self.nobody, |account| &account.hash);
        let stored = PasswordHash::new(stored).map_err(|_| Wrong::Login)?;
        let short = password.len() <= MAX_PASSWORD;
        let fits = short && Argon2::default().verify_password(password.as_bytes(), &stored).is_ok();
        drop(turn);
        let role = found.filter(|_| fits).map(|account| account.role).ok_or(Wrong::Login)?;
        lock(&self.limits).succeed(Instant::now(), source, account);
        Ok(role)
    }

    /// Adds a new device of an account to those that a browser keeps. Its mark is made from the account's hash: a new password
    /// forgets all of its devices.
    pub(crate) fn with_device(&self, user: &str, kept: &str) -> Option<String> {
        let key = self.device_key(user)?;
        let mut number = [0; DEVICE_NUMBER];
        getrandom::fill(&mut number).ok()?;
        let number = hex(&number);
        let mark = hmac::sign(&key, marked(user, &number).as_bytes());
        let new = format!("{number}{}", hex(mark.as_ref()));
        let others = kept.split(BETWEEN).filter(|device| {
            device.len() == DEVICE && device.bytes().all(|b| b.is_ascii_hexdigit())
        });
        let others = others.filter(|device| self.number_of(user, device).is_none());
        let all: Vec<&str> = core::iter::once(&*new).chain(others).take(MAX_DEVICES).collect();
        Some(all.join(&BETWEEN.to_string()))
    }

    /// Returns the place of who signs in to an account: the device, if it is one of those that a browser keeps.
    pub(crate) fn source(&self, user: &str, kept: &str, otherwise: SignInPlace) -> SignInPlace {
        let mut devices = kept.split(BETWEEN).take(MAX_DEVICES);
        let number = devices.find_map(|device| self.number_of(user, device));
        number.map_or(otherwise, |number| SignInPlace::Device(number.to_owned()))
    }

    /// Returns the number of a device, if it is one of this account.
    fn number_of<'d>(&self, user: &str, device: &'d str) -> Option<&'d str> {
        let key = self.device_key(user)?;
        let (number, mark) = device.split_at_checked(2 * DEVICE_NUMBER)?;
        let mark = bytes(mark)?;
        hmac::verify(&key, marked(user, number).as_bytes(), &mark).ok().map(|()| number)
    }

    fn device_key(&self, user: &str) -> Option<hmac::Key> {
        let account = self.list.get(user)?;
        Some(hmac::Key::new(hmac::HMAC_SHA256, account.hash.as_bytes()))
    }
}

/// Place in the line of those whose passwords are tried.
struct Waiting<'a> {
    count: &'a AtomicUsize,
    /// Number of those who waited before.
    before: usize,
}

impl<'a> Waiting<'a> {
    fn enter(count: &'a AtomicUsize) -> Self {
        Self { count, before: count.fetch_add(1, Relaxed) }
    }
}

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        self.count.fetch_sub(1, Relaxed);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns what the mark of a device stands for.
fn marked(user: &str, number: &str) -> String {
    format!("device {number} of {user}")
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns the bytes of a text of hexadecimal digits.
fn bytes(text: &str) -> Option<Vec<u8>> {
    let digits: Option<Vec<u32>> = text.chars().map(|c| c.to_digit(16)).collect();
    let digits = digits?;
    digits.chunks(2).map(|pair| u8::try_from(pair.first()? * 16 + pair.get(1)?).ok()).collect()
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

/// Reason why a password has no hash.
#[derive(Debug)]
enum NoHash {
    /// The system has no random numbers.
    Random(getrandom::Error),
    /// The password cannot be hashed.
    Hash(argon2::password_hash::Error),
}

impl fmt::Display for NoHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Random(why) => write!(f, "the system has no random numbers: {why}"),
            Self::Hash(why) => write!(f, "the password cannot be hashed: {why}"),
        }
    }
}

fn hash(password: &str) -> Result<String, NoHash> {
    let mut salt = [0; 16];
    getrandom::fill(&mut salt).map_err(NoHash::Random)?;
    let salt = SaltString::encode_b64(&salt).map_err(NoHash::Hash)?;
    let hash = Argon2::default().hash_password(password.as_bytes(), &salt).map_err(NoHash::Hash)?;
    Ok(hash.to_string())
}

/// Returns a hash of no password of anybody: an unknown user takes as long as a wrong password. It is made once.
fn nobody() -> Result<String, NoHash> {
    static NOBODY: OnceLock<String> = OnceLock::new();
    if let Some(known) = NOBODY.get() {
        return Ok(known.clone());
    }
    let new = hash("nobody has this password")?;
    Ok(NOBODY.get_or_init(|| new).clone())
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
    let hash = hash(password).map_err(|why| why.to_string())?;
    text.push_str(&format!("{name} {role} {hash}\n"));
    hal_output::install(path, text.as_bytes(), 0o600)
        .map_err(|e| format!("{file}: {}", hal_output::reason(&e)))
}

#[cfg(test)]
mod tests {
    //! Files of accounts, and passwords.

    use super::{Accounts, MAX_DEVICES, Relaxed, Role, SignInPlace, Wrong, add, hash, parse};
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
            assert_eq!(
                accounts.check(user, password, &SignInPlace::User(1)),
                role,
                "{user} {password}"
            );
        }
        strangers_keep_no_device_out(&accounts);
        // A new password forgets the devices of its account.
        let kept = accounts.with_device("ana", "").unwrap();
        assert_ne!(accounts.source("ana", &kept, SignInPlace::User(2)), SignInPlace::User(2));
        add(&file, "ana=operator", &mut &b"another password\n"[..]).unwrap();
        let changed = Accounts::read(&file).unwrap();
        assert_eq!(changed.source("ana", &kept, SignInPlace::User(2)), SignInPlace::User(2));
        fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
        assert!(Accounts::read(&file).unwrap_err().contains("chmod 600"));
        fs::remove_dir_all(&folder).unwrap();
    }
    /// Guesses from one place, and then signs in there with a device that is known.
    fn strangers_keep_no_device_out(accounts: &Accounts) {
        let place = SignInPlace::User(65_534);
        let mut kept = String::new();
        for user in ["ana", "eva"].repeat(6) {
            kept = accounts.with_device(user, &kept).unwrap();
        }
        assert_eq!(kept.split('~').count(), 2, "one for each account");
        let guess = || accounts.check("ana", "a wrong password", &place);
        let wrong = (0..20).take_while(|_| guess() == Err(Wrong::Login)).count();
        assert_eq!(wrong, 5);
        assert!(matches!(guess(), Err(Wrong::Haste(_))));
        assert!(matches!(accounts.check("ana", "correct horse", &place), Err(Wrong::Haste(_))));
        let known = accounts.source("ana", &kept, place.clone());
        assert_eq!(accounts.check("ana", "correct horse", &known), Ok(Role::Operator));
        // While others wait for their turn, too.
        accounts.waiting.store(100, Relaxed);
        let fresh = SignInPlace::User(7);
        assert!(matches!(accounts.check("ana", "correct horse", &fresh), Err(Wrong::Haste(_))));
        assert_eq!(accounts.check("ana", "correct horse", &known), Ok(Role::Operator));
        accounts.waiting.store(0, Relaxed);
        assert_eq!(accounts.check("ana", "correct horse", &fresh), Ok(Role::Operator));
        // A device is one of its account alone, and nobody makes one.
        let (number, mark) = kept.split_once('~').unwrap().0.split_at(16);
        for forged in [
            format!("{number}{}", mark.chars().rev().collect::<String>()),
            format!("{}{mark}", "0".repeat(16)),
            format!("{number}{}", &mark[..62]),
            "é".repeat(40),
            "~".repeat(1000),
            String::new(),
        ] {
            assert_eq!(accounts.source("eva", &forged, place.clone()), place, "{forged}");
        }
        assert_eq!(accounts.source("nobody", &kept, place.clone()), place);
        let many = vec![&*kept; 50].join("~");
        let few = accounts.with_device("ana", &many).unwrap();
        assert!(few.split('~').count() <= MAX_DEVICES);
    }
}
