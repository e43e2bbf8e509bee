//! Waits after sign-ins that have failed. They grow by address, the sooner the more has been tried at the account, and a device
//! that is known waits for its own failures alone: strangers keep nobody out.

use std::{
    collections::BTreeMap,
    net::{IpAddr, Ipv6Addr, SocketAddr},
    time::Duration,
};
use tokio::time::Instant;

/// Number of tries from one place before it waits.
const FREE: u32 = 5;
/// The same at an account at which strangers have tried [`HOT`] passwords.
const FREE_IF_HOT: u32 = 1;
const HOT: u32 = 20;
/// First wait, which doubles with each further failure, and longest one.
const FIRST_WAIT: Duration = Duration::from_secs(1);
const MAX_WAIT: Duration = Duration::from_mins(15);
/// Time after which failures are forgotten.
const FORGOTTEN: Duration = Duration::from_hours(1);
/// Number of places and accounts whose failures are known.
const MAX_KNOWN: usize = 4096;

/// Place from which somebody signs in.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum SignInPlace {
    /// An address; of IPv6 the network, in which a computer chooses addresses as it likes.
    Address(IpAddr),
    /// A user of this computer.
    User(u32),
    /// A device from which somebody has signed in to this account before, by its number.
    Device(String),
}

/// Addresses of both ends of a connection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peer {
    pub(crate) theirs: SocketAddr,
    pub(crate) ours: SocketAddr,
}

impl Peer {
    /// Returns the place at the other end. On this computer, it is a user: all of them have the same address.
    pub(crate) fn source(self) -> SignInPlace {
        let user = || hal_lease::user_at(self.theirs, self.ours).map(SignInPlace::User);
        let [theirs, ours] = [self.theirs, self.ours].map(|end| end.ip().to_canonical());
        // A browser here that opens the panel's network address comes from that address.
        let is_here = theirs.is_loopback() || theirs == ours;
        is_here.then(user).flatten().unwrap_or_else(|| SignInPlace::at(self.theirs.ip()))
    }
}

impl SignInPlace {
    /// Returns the place of an address.
    pub(crate) fn at(address: IpAddr) -> Self {
        Self::Address(match address.to_canonical() {
            IpAddr::V6(ip) if !ip.is_loopback() => {
                Ipv6Addr::from(u128::from(ip) & !u128::from(u64::MAX)).into()
            }
            other => other,
        })
    }
}

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    SignInPlace(SignInPlace),
    Account(String),
}

#[derive(Clone, Copy, Debug)]
struct Failures {
    count: u32,
    last: Instant,
    /// End of the wait.
    until: Instant,
}

/// Failures of late.
#[derive(Debug, Default)]
pub(crate) struct Limits {
    known: BTreeMap<Key, Failures>,
}

impl Limits {
    /// Counts a try as one that fails, or returns how long its place still waits.
    pub(crate) fn begin(
        &mut self,
        now: Instant,
        source: &SignInPlace,
        user: &str,
    ) -> Result<(), Duration> {
        self.known.retain(|_, failures| now.saturating_duration_since(failures.last) < FORGOTTEN);
        let (place, account) = (Key::SignInPlace(source.clone()), Key::Account(user.to_owned()));
        let wait = self.known.get(&place).map(|f| f.until.saturating_duration_since(now));
        if let Some(wait) = wait.filter(|wait| !wait.is_zero()) {
            return Err(wait);
        }
        let is_known = matches!(source, SignInPlace::Device(_));
        let hot = !is_known && self.known.get(&account).is_some_and(|f| f.count >= HOT);
        self.count(now, place, if hot { FREE_IF_HOT } else { FREE });
        if !is_known {
            // Strangers make others wait at no account: they only shorten what each place may try.
            self.count(now, account, u32::MAX);
        }
        Ok(())
    }

    /// Takes a try back that has not failed. Failures before it stay: who has an account could try others between.
    pub(crate) fn succeed(&mut self, now: Instant, source: &SignInPlace, user: &str) {
        for key in [Key::SignInPlace(source.clone()), Key::Account(user.to_owned())] {
            let Some(failures) = self.known.get_mut(&key) else { continue };
            failures.count = failures.count.saturating_sub(1);
            failures.until = now;
            if failures.count == 0 {
                self.known.remove(&key);
            }
        }
    }

    fn count(&mut self, now: Instant, key: Key, free: u32) {
        if self.known.len() >= MAX_KNOWN && !self.known.contains_key(&key) {
            let oldest = self.known.iter().min_by_key(|(_, f)| (f.until, f.last));
            let oldest = oldest.map(|(key, _)| key.clone());
            oldest.and_then(|key| self.known.remove(&key));
        }
        let failures =
            self.known.entry(key).or_insert(Failures { count: 0, last: now, until: now });
        failures.count = failures.count.saturating_add(1);
        failures.last = now;
        let beyond = failures.count.checked_sub(free);
        let wait = beyond.map(|n| FIRST_WAIT.saturating_mul(1 << n.min(20)).min(MAX_WAIT));
        failures.until = now + wait.unwrap_or_default();
    }
}

#[cfg(test)]
mod tests {
    //! Guesses of strangers beside the sign-ins of people, in a time of the test's own.

    use super::{Duration, FORGOTTEN, Instant, Limits, MAX_KNOWN, MAX_WAIT, SignInPlace};

    const ANA: &str = "ana";

    fn at(text: &str) -> SignInPlace {
        SignInPlace::at(text.parse().unwrap())
    }

    /// Returns how many of the guesses from a place are tried, 100 a second for so long.
    fn guess(limits: &mut Limits, begun: Instant, source: &SignInPlace, seconds: u32) -> u32 {
        let times = (0..100 * seconds).map(|n| begun + n * Duration::from_millis(10));
        times.filter(|now| limits.begin(*now, source, ANA).is_ok()).map(|_| 1).sum()
    }

    #[test]
    fn waits_of_one_place_grow_and_end() {
        let (mut limits, begun) = (Limits::default(), Instant::now());
        let stranger = at("192.0.2.1");
        let mut now = begun;
        let mut waits = Vec::new();
        for _ in 0..18 {
            if let Err(wait) = limits.begin(now, &stranger, ANA) {
                waits.push(wait.as_secs());
                now += wait;
                limits.begin(now, &stranger, ANA).unwrap();
            }
        }
        assert_eq!(waits, [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 900, 900, 900]);
        // What is refused meanwhile makes the wait no longer.
        assert!((0..1000).all(|_| limits.begin(now, &stranger, ANA).is_err()));
        limits.begin(now + MAX_WAIT, &stranger, ANA).unwrap();
        let later = now + MAX_WAIT + FORGOTTEN;
        assert_eq!(guess(&mut limits, later, &stranger, 1), 5, "an hour later they are forgotten");
    }

    #[test]
    fn a_stranger_keeps_nobody_out() {
        let (mut limits, begun) = (Limits::default(), Instant::now());
        let tried = guess(&mut limits, begun, &at("192.0.2.1"), 3600);
        assert!(tried <= 20, "{tried} of 360000 guesses are tried in an hour");
        // The owner of the account comes from elsewhere, or by a device that is known, behind the same address too.
        let now = begun + Duration::from_hours(1);
        limits.begin(now, &at("192.0.2.2"), ANA).unwrap();
        limits.begin(now, &SignInPlace::Device("a".to_owned()), ANA).unwrap();
        // On this computer, users are places of their own.
        guess(&mut limits, now, &SignInPlace::User(65_534), 10);
        limits.begin(now, &SignInPlace::User(1000), ANA).unwrap();
    }

    #[test]
    fn at_an_account_that_many_try_each_place_has_one_try() {
        let (mut limits, now) = (Limits::default(), Instant::now());
        let mut tried = 0;
        for n in 0..1000 {
            let source = at(&format!("192.0.{}.{}", n / 250, n % 250));
            tried += (0..10).filter(|_| limits.begin(now, &source, ANA).is_ok()).count();
        }
        assert!(tried <= 1000 + 20, "{tried} tries of 1000 places");
        limits.begin(now, &at("198.51.100.1"), ANA).unwrap();
        // Another account is not concerned.
        let elsewhere = at("198.51.100.2");
        assert!((0..5).all(|_| limits.begin(now, &elsewhere, "eva").is_ok()));
    }

    #[test]
    fn a_sign_in_between_guesses_brings_no_further_ones() {
        let (mut limits, now) = (Limits::default(), Instant::now());
        let (stranger, mut tried) = (at("192.0.2.1"), 0);
        for _ in 0..100 {
            if limits.begin(now, &stranger, ANA).is_err() {
                break;
            }
            tried += 1;
            if limits.begin(now, &stranger, "own").is_ok() {
                limits.succeed(now, &stranger, "own");
            }
        }
        assert_eq!(tried, 5);
        // Who signs in rightly never waits.
        let person = at("192.0.2.2");
        for _ in 0..100 {
            limits.begin(now, &person, "eva").unwrap();
            limits.succeed(now, &person, "eva");
        }
    }

    #[test]
    fn a_computer_with_many_addresses_is_one_place_and_memory_is_bounded() {
        let (mut limits, now) = (Limits::default(), Instant::now());
        let tried =
            (0..1000).filter(|n| limits.begin(now, &at(&format!("2001:db8::{n:x}")), ANA).is_ok());
        assert_eq!(tried.count(), 5);
        for n in 0..5000_u32 {
            let source = at(&format!("2001:db8:{:x}:{:x}::1", n / 256, n % 256));
            limits.begin(now, &source, &n.to_string()).unwrap_or_default();
        }
        assert!(limits.known.len() <= MAX_KNOWN);
        limits.begin(now, &at("2001:db8::7"), ANA).unwrap_err();
        assert_eq!(at("::ffff:192.0.2.1"), at("192.0.2.1"));
    }
}
