//! A network of the test's own, whose link can be taken down.

use hal_tests::tools::report;
use std::{
    net::{IpAddr, Ipv4Addr},
    path::Path,
    process::{Command, Stdio, id},
};

/// Beginning of the names of namespaces; the process follows.
const PREFIX: &str = "ferrule";

/// Runs `ip` with these words; returns whether it did as told.
fn ip(words: &str) -> bool {
    let mut ip = Command::new("ip");
    ip.args(words.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::null());
    ip.status().is_ok_and(|status| status.success())
}

/// Removes what tests that were killed have left.
fn sweep() {
    let Ok(list) = Command::new("ip").args(["netns", "list"]).output() else { return };
    let list = String::from_utf8_lossy(&list.stdout).into_owned();
    for name in list.lines().filter_map(|line| line.split_whitespace().next()) {
        let Some(pid) = name.strip_prefix(PREFIX).and_then(|pid| pid.parse::<u32>().ok()) else {
            continue;
        };
        if !Path::new(&format!("/proc/{pid}")).exists() {
            ip(&format!("link del fe{pid}"));
            ip(&format!("netns del {name}"));
        }
    }
}

/// A network namespace that reaches this computer by one link.
#[derive(Debug)]
pub(super) struct Net {
    /// Name of the namespace.
    pub(super) name: String,
    /// This computer's end of the link, and its address.
    end: String,
    pub(super) address: IpAddr,
}

impl Net {
    /// Makes the namespace; reports what is skipped where this user or computer cannot.
    pub(super) fn make() -> Option<Self> {
        sweep();
        // Each process has four addresses of its own.
        let [.., third, fourth] = (id() << 2).to_be_bytes();
        let far_address = Ipv4Addr::new(10, 213, third, fourth | 2);
        let net = Self {
            name: format!("{PREFIX}{}", id()),
            end: format!("fe{}", id()),
            address: Ipv4Addr::new(10, 213, third, fourth | 1).into(),
        };
        let Self { name, end, address } = &net;
        let far = format!("ff{}", id());
        let made = [
            format!("netns add {name}"),
            format!("link add {end} type veth peer name {far}"),
            format!("link set {far} netns {name}"),
            format!("addr add {address}/30 dev {end}"),
            format!("link set {end} up"),
            format!("-n {name} addr add {far_address}/30 dev {far}"),
            format!("-n {name} link set {far} up"),
            format!("-n {name} link set lo up"),
        ];
        let failed = made.iter().find(|words| !ip(words));
        if let Some(words) = failed {
            report(&format!(
                "cuts of a link need a network namespace: 'ip {words}' fails (run it as root)"
            ));
            return None;
        }
        Some(net)
    }

    /// Takes the link up or down.
    pub(super) fn link(&self, is_up: bool) {
        let state = if is_up { "up" } else { "down" };
        assert!(ip(&format!("link set {} {state}", self.end)), "the link does not go {state}");
    }
}

impl Drop for Net {
    fn drop(&mut self) {
        ip(&format!("link del {}", self.end));
        ip(&format!("netns del {}", self.name));
    }
}
