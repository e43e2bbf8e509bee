//! Needs of a network address: accounts, a certificate, and the names of the server.

use crate::{
    accounts::Accounts,
    options::Options,
    tls::{self, Tls},
};
use std::net::SocketAddr;

/// Accounts, certificate and names.
pub(crate) struct Security {
    pub(crate) accounts: Option<Accounts>,
    pub(crate) tls: Option<Tls>,
    /// Names and addresses of the server, without port.
    names: Vec<String>,
}

impl core::fmt::Debug for Security {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Security").field("names", &self.names).finish_non_exhaustive()
    }
}

impl Security {
    /// Reads the files, and refuses a network address without them.
    pub(crate) fn open(options: &Options) -> Result<Self, String> {
        let (listen, ip) = (options.listen, options.listen.ip());
        Self::check_needs(listen, options)?;
        if ip.is_unspecified() && options.name.is_empty() {
            return Err(format!(
                "{listen} stands for every address: --name states the one that browsers open"
            ));
        }
        let accounts = options.accounts.as_deref().map(Accounts::read).transpose()?;
        let mut names = options.name.clone();
        names.extend((!ip.is_unspecified()).then(|| ip.to_string()));
        names.push("localhost".to_owned());
        let tls = options.certificate.as_deref().map(|file| tls::open(file, &names)).transpose()?;
        Ok(Self { accounts, tls, names })
    }

    /// Refuses a network address without accounts and a certificate.
    pub(crate) fn check_needs(listen: SocketAddr, options: &Options) -> Result<(), String> {
        let has_both = options.accounts.is_some() && options.certificate.is_some();
        if listen.ip().is_loopback() || has_both {
            return Ok(());
        }
        Err(format!("{listen} is a network address: it needs --accounts and --certificate"))
    }

    /// Returns the scheme of the server's addresses.
    pub(crate) const fn scheme(&self) -> &'static str {
        if self.tls.is_some() { "https" } else { "http" }
    }

    /// Returns the address that browsers open.
    pub(crate) fn origin(&self, address: SocketAddr) -> String {
        let host = if address.ip().is_unspecified() {
            self.names.first().map(|name| format!("{name}:{}", address.port()))
        } else {
            None
        };
        format!("{}://{}", self.scheme(), host.unwrap_or_else(|| address.to_string()))
    }

    /// Returns whether a request for this host is for the server at this address.
    pub(crate) fn is_host(&self, address: SocketAddr, host: &str) -> bool {
        let port = address.port();
        let usual = if self.tls.is_some() { 443 } else { 80 };
        let is_name = |name: &str| {
            let name = if name.contains(':') { format!("[{name}]") } else { name.to_owned() };
            host.eq_ignore_ascii_case(&format!("{name}:{port}"))
                || (port == usual && host.eq_ignore_ascii_case(&name))
        };
        self.names.iter().any(|name| is_name(name))
    }
}

#[cfg(test)]
mod tests {
    //! Addresses, and the names of a server.

    use super::{Options, Security};
    use clap::Parser as _;

    fn open(words: &str) -> Result<Security, String> {
        Security::open(&Options::parse_from(words.split_whitespace()))
    }

    #[test]
    fn a_network_address_needs_accounts_and_a_certificate() {
        for (words, why) in [
            ("halpanel --listen 192.0.2.1:443", "is a network address"),
            ("halpanel --listen 192.0.2.1:443 --accounts none", "is a network address"),
            ("halpanel --listen [::]:443 --certificate none", "is a network address"),
            ("halpanel --listen 0.0.0.0:1 --accounts none --certificate none", "--name states"),
            ("halpanel --listen 192.0.2.1:1 --accounts /nowhere/a --certificate c", "/nowhere/a: "),
            ("halpanel --certificate /nowhere/c", "/nowhere/c: "),
        ] {
            let said = open(words).unwrap_err();
            assert!(said.contains(why), "{words}: {said}");
        }
    }

    #[test]
    fn a_request_names_the_server() {
        let here = open("halpanel --name machine.local").unwrap();
        let address = "127.0.0.1:7776".parse().unwrap();
        for (host, right) in [
            ("127.0.0.1:7776", true),
            ("localhost:7776", true),
            ("Machine.local:7776", true),
            ("machine.local", false),
            ("127.0.0.1:80", false),
            ("evil.example:7776", false),
            ("", false),
        ] {
            assert_eq!(here.is_host(address, host), right, "{host}");
        }
        let usual = "127.0.0.1:80".parse().unwrap();
        assert!(here.is_host(usual, "machine.local"));
        assert_eq!(here.origin(address), "http://127.0.0.1:7776");
        let here = open("halpanel --listen [::1]:7776").unwrap();
        assert!(here.is_host("[::1]:7776".parse().unwrap(), "[::1]:7776"));
    }
}
