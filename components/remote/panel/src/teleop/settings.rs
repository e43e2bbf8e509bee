//! Settings of teleoperation: the address, who may connect, and how a cancellation ends a job.

use super::ADDRESS;
use crate::options::Options;
use hal_ini::Ini;
use std::net::{IpAddr, SocketAddr};

/// Largest number of entries of the list of addresses.
const MAX_ALLOWED: usize = 64;
/// Number of bits before an IPv4 address within an IPv6 address.
const MAPPED_BITS: u32 = 96;

/// Addresses with the same beginning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Net {
    address: IpAddr,
    /// Number of bits that count.
    bits: u32,
}

/// The settings.
#[derive(Clone, Debug, Default)]
pub(crate) struct Settings {
    /// Address, if one is stated.
    pub(crate) address: Option<SocketAddr>,
    /// Addresses of clients; empty for all.
    allowed: Vec<Net>,
    /// A cancelled job ends at the end of its command.
    pub(crate) ends_command: bool,
}

impl Settings {
    /// Reads the options and the section `[REMOTE]`.
    pub(crate) fn read(options: &Options, ini: Option<&Ini>) -> Result<Self, String> {
        let get = |name: &str| ini.and_then(|ini| ini.get("REMOTE", name)).map(str::trim);
        let address = match get("TELEOP").filter(|_| options.teleop.is_none()) {
            None => options.teleop,
            Some(text) => Some(text.parse().map_err(|_| {
                format!("[REMOTE]TELEOP is '{text}', must be ADDRESS:PORT, as {ADDRESS}")
            })?),
        };
        let allowed: Result<Vec<Net>, String> =
            get("TELEOP_ALLOW").unwrap_or_default().split_whitespace().map(Net::parse).collect();
        let allowed = allowed?;
        if allowed.len() > MAX_ALLOWED {
            return Err(format!("[REMOTE]TELEOP_ALLOW has more than {MAX_ALLOWED} addresses"));
        }
        let ends_command = match get("TELEOP_CANCEL") {
            None | Some("now") => false,
            Some("block") => true,
            Some(other) => {
                return Err(format!("[REMOTE]TELEOP_CANCEL is '{other}', must be now or block"));
            }
        };
        Ok(Self { address, allowed, ends_command })
    }

    /// Returns whether a client at this address may connect.
    pub(super) fn admits(&self, client: IpAddr) -> bool {
        let client = client.to_canonical();
        self.allowed.is_empty() || self.allowed.iter().any(|net| net.has(client))
    }
}

impl Net {
    fn parse(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "[REMOTE]TELEOP_ALLOW has '{text}', must be addresses as 192.0.2.7 or 192.0.2.0/24"
            )
        };
        let (address, bits) = text.split_once('/').map_or((text, None), |(a, b)| (a, Some(b)));
        let stated: IpAddr = address.parse().map_err(|_| wrong())?;
        let most = if stated.is_ipv4() { 32 } else { 128 };
        let bits: u32 = bits.map_or(Ok(most), |b| b.parse().map_err(|_| wrong()))?;
        // Clients with IPv4 are compared as such, also with an entry that is IPv4 within IPv6.
        let address = stated.to_canonical();
        let mapped = if address == stated { 0 } else { MAPPED_BITS };
        let bits = bits.checked_sub(mapped).filter(|_| bits <= most).ok_or_else(wrong)?;
        Ok(Self { address, bits })
    }

    fn has(self, client: IpAddr) -> bool {
        let beginning = |address: u128, width: u32| {
            address.checked_shr(width - self.bits.min(width)).unwrap_or(0)
        };
        match (self.address, client) {
            (IpAddr::V4(a), IpAddr::V4(b)) => {
                beginning(a.to_bits().into(), 32) == beginning(b.to_bits().into(), 32)
            }
            (IpAddr::V6(a), IpAddr::V6(b)) => {
                beginning(a.to_bits(), 128) == beginning(b.to_bits(), 128)
            }
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    //! Lists of addresses, and settings that are none.

    use super::Settings;
    use crate::options::Options;
    use clap::Parser as _;
    use hal_ini::Ini;

    fn read(entries: &str) -> Result<Settings, String> {
        let ini = Ini::parse("m.ini", format!("[REMOTE]\n{entries}\n").as_bytes()).unwrap();
        Settings::read(&Options::parse_from(["halpanel"]), Some(&ini))
    }

    #[test]
    fn only_addresses_of_the_list_may_connect() {
        for (list, client, admitted) in [
            ("", "198.51.100.1", true),
            ("192.0.2.7", "192.0.2.7", true),
            ("192.0.2.7", "192.0.2.8", false),
            ("192.0.2.7", "::ffff:192.0.2.7", true),
            ("::ffff:192.0.2.7", "192.0.2.7", true),
            ("::ffff:192.0.2.7", "::ffff:192.0.2.7", true),
            ("::ffff:192.0.2.7", "192.0.2.8", false),
            ("::ffff:192.0.2.0/120", "192.0.2.8", true),
            ("::ffff:192.0.2.0/120", "192.0.3.8", false),
            ("::ffff:0:0/96", "192.0.2.8", true),
            ("::ffff:0:0/96", "2001:db8::1", false),
            ("192.0.2.0/24 198.51.100.1", "192.0.2.200", true),
            ("192.0.2.0/24 198.51.100.1", "198.51.100.1", true),
            ("192.0.2.0/24 198.51.100.1", "198.51.100.2", false),
            ("192.0.2.0/0", "203.0.113.9", true),
            ("192.0.2.0/0", "2001:db8::1", false),
            ("2001:db8::/32", "2001:db8:1::5", true),
            ("2001:db8::/32", "2001:db9::5", false),
            ("::/0", "2001:db9::5", true),
        ] {
            let settings = read(&format!("TELEOP_ALLOW = {list}")).unwrap();
            assert_eq!(settings.admits(client.parse().unwrap()), admitted, "{list}: {client}");
        }
    }

    #[test]
    fn settings_that_are_none_are_refused_by_name() {
        for (entry, why) in [
            ("TELEOP = here", "[REMOTE]TELEOP is 'here', must be ADDRESS:PORT"),
            ("TELEOP_ALLOW = 192.0.2.7/33", "TELEOP_ALLOW has '192.0.2.7/33', must be addresses"),
            ("TELEOP_ALLOW = 192.0.2.7 localhost", "TELEOP_ALLOW has 'localhost'"),
            ("TELEOP_ALLOW = 192.0.2.7/-1", "TELEOP_ALLOW has '192.0.2.7/-1'"),
            ("TELEOP_ALLOW = ::ffff:0:0/95", "TELEOP_ALLOW has '::ffff:0:0/95', must be"),
            ("TELEOP_ALLOW = ::ffff:0:0/129", "TELEOP_ALLOW has '::ffff:0:0/129', must be"),
            ("TELEOP_CANCEL = later", "TELEOP_CANCEL is 'later', must be now or block"),
        ] {
            let said = read(entry).unwrap_err();
            assert!(said.contains(why), "{entry}: {said}");
        }
        let many = "192.0.2.7 ".repeat(65);
        assert!(read(&format!("TELEOP_ALLOW = {many}")).unwrap_err().contains("more than 64"));
        assert!(read("TELEOP_CANCEL = block").unwrap().ends_command);
        assert!(!read("TELEOP_CANCEL = now").unwrap().ends_command);
    }
}
