//! The user at the other end of a connection of this computer.

use std::{
    fs,
    net::{SocketAddr, TcpStream},
    os::unix::fs::MetadataExt as _,
};

/// Table of the kernel: each connection with its user.
const TABLE: &str = "/proc/net/tcp";

/// Returns whether the other end belongs to the user of this process, or to root.
#[must_use]
pub fn is_own(stream: &TcpStream) -> bool {
    let own = fs::metadata("/proc/self").map(|process| process.uid());
    let ends = stream.peer_addr().and_then(|theirs| Ok((theirs, stream.local_addr()?)));
    let (Ok(own), Ok((theirs, ours))) = (own, ends) else { return false };
    user_at(theirs, ours).is_some_and(|user| user == own || user == 0)
}

/// Returns the user at the other end of an open connection of this computer, by the addresses of both ends.
#[must_use]
pub fn user_at(theirs: SocketAddr, ours: SocketAddr) -> Option<u32> {
    user_of(&fs::read_to_string(TABLE).ok()?, theirs, ours)
}

/// Returns the user of a socket in the table.
fn user_of(table: &str, local: SocketAddr, remote: SocketAddr) -> Option<u32> {
    let (local, remote) = (entry(local)?, entry(remote)?);
    table.lines().find_map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let is = words.get(1) == Some(&&*local) && words.get(2) == Some(&&*remote);
        // A connection that has ended has no socket, and shows user 0.
        let is_open = words.get(9).is_some_and(|inode| *inode != "0");
        if is && is_open { words.get(7)?.parse().ok() } else { None }
    })
}

/// Returns an address as the table has it.
fn entry(address: SocketAddr) -> Option<String> {
    let SocketAddr::V4(address) = address else { return None };
    let ip = u32::from_ne_bytes(address.ip().octets());
    Some(format!("{ip:08X}:{:04X}", address.port()))
}

#[cfg(test)]
mod tests {
    //! Entries of the table.

    use super::user_of;

    #[test]
    fn the_user_is_that_of_an_open_connection() {
        let table = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n   \
0: 0100007F:138F 0100007F:A000 01 00000000:00000000 00:00000000 00000000     0        0 11 1\n   \
1: 0100007F:A000 0100007F:138F 01 00000000:00000000 00:00000000 00000000  1000        0 12 1\n   \
2: 0100007F:A001 0100007F:138F 06 00000000:00000000 00:00000000 00000000     0        0 0 3\n";
        let at = |port: u16| format!("127.0.0.1:{port}").parse().unwrap();
        assert_eq!(user_of(table, at(0xa000), at(5007)), Some(1000));
        assert_eq!(user_of(table, at(5007), at(0xa000)), Some(0));
        assert_eq!(user_of(table, at(0xa001), at(5007)), None);
        assert_eq!(user_of(table, at(1), at(5007)), None);
        assert_eq!(user_of("", at(1), at(5007)), None);
    }
}
