//! The user at the other end of a connection of this computer.

use hal_protocol::Place;
use std::{
    fs,
    net::{IpAddr, SocketAddr, TcpStream},
    os::unix::fs::MetadataExt as _,
    path::Path,
};

/// Tables of the kernel: each connection with its user. A socket for both kinds of addresses is in the second one.
const TABLES: [&str; 2] = ["/proc/net/tcp", "/proc/net/tcp6"];

/// Returns whether the instance is another user's, so that this process is its guest. Root is nobody's.
#[must_use]
pub fn is_guest(place: &Place) -> bool {
    let user = |path: &Path| fs::metadata(path).map(|file| file.uid());
    let (Ok(own), Ok(theirs)) = (user(Path::new("/proc/self")), user(place.folder())) else {
        return false;
    };
    is_other(own, theirs)
}

/// Returns whether a user is a guest at another's. Root is nobody's.
const fn is_other(own: u32, theirs: u32) -> bool {
    own != 0 && own != theirs
}

/// Returns whether a user may act for another: each for itself, and root for all.
const fn may_act(user: u32, own: u32) -> bool {
    user == own || user == 0
}

/// Returns whether the other end belongs to the user of this process, or to root.
#[must_use]
pub fn is_own(stream: &TcpStream) -> bool {
    let own = fs::metadata("/proc/self").map(|process| process.uid());
    let ends = stream.peer_addr().and_then(|theirs| Ok((theirs, stream.local_addr()?)));
    let (Ok(own), Ok((theirs, ours))) = (own, ends) else { return false };
    user_at(theirs, ours).is_some_and(|user| may_act(user, own))
}

/// Returns the user at the other end of an open connection of this computer, by the addresses of both ends.
#[must_use]
pub fn user_at(theirs: SocketAddr, ours: SocketAddr) -> Option<u32> {
    let read = |table| user_of(&fs::read_to_string(table).ok()?, theirs, ours);
    TABLES.into_iter().find_map(read)
}

/// Returns the user of a socket in a table.
fn user_of(table: &str, local: SocketAddr, remote: SocketAddr) -> Option<u32> {
    let (local, remote) = (entries(local), entries(remote));
    table.lines().find_map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let is = |n: usize, entries: &[String]| {
            words.get(n).is_some_and(|word| entries.iter().any(|entry| entry == word))
        };
        // A connection that has ended has no socket, and shows user 0.
        let is_open = words.get(9).is_some_and(|inode| *inode != "0");
        if is(1, &local) && is(2, &remote) && is_open { words.get(7)?.parse().ok() } else { None }
    })
}

/// Returns an address as the tables have it: one of IPv4 also as that of a socket for both kinds.
fn entries(address: SocketAddr) -> Vec<String> {
    let port = address.port();
    let six = |octets: [u8; 16]| {
        let words = octets.chunks_exact(4).map(|word| {
            let word = word.iter().rev().fold(0, |all, byte| all << 8 | u32::from(*byte));
            format!("{:08X}", if cfg!(target_endian = "little") { word } else { word.swap_bytes() })
        });
        format!("{}:{port:04X}", words.collect::<String>())
    };
    match address.ip().to_canonical() {
        IpAddr::V4(ip) => {
            let four = u32::from_ne_bytes(ip.octets());
            vec![format!("{four:08X}:{port:04X}"), six(ip.to_ipv6_mapped().octets())]
        }
        IpAddr::V6(ip) => vec![six(ip.octets())],
    }
}

#[cfg(test)]
mod tests {
    //! Entries of the table.

    use super::{is_guest, is_other, may_act, user_at, user_of};

    #[test]
    fn root_is_no_guest_and_acts_for_all() {
        let rows = [
            (0, 0, false, true),
            (0, 7, false, true),
            (7, 0, true, false),
            (7, 7, false, true),
            (7, 8, true, false),
        ];
        for (user, other, guest, acts) in rows {
            assert_eq!(
                (is_other(user, other), may_act(user, other)),
                (guest, acts),
                "{user} {other}"
            );
        }
        // A folder of this process is its user's.
        let place = hal_protocol::Place::at(std::env::temp_dir().join("none"), "default").unwrap();
        assert!(!is_guest(&place), "a folder that is not there");
        let own = std::env::temp_dir().join(format!("ferrule-guest-{}", std::process::id()));
        std::fs::create_dir_all(&own).unwrap();
        assert!(!is_guest(&hal_protocol::Place::at(&own, "default").unwrap()));
        std::fs::remove_dir(&own).unwrap();
    }

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

    #[test]
    fn sockets_of_the_second_table_are_found_by_either_kind_of_address() {
        let table = "  sl  local_address remote_address st tx_queue rx_queue tr tm->when retrnsmt uid timeout inode\n   \
0: 00000000000000000000000001000000:138F 00000000000000000000000001000000:A000 01 0:0 00:0 0 0 0 11 1\n   \
1: 00000000000000000000000001000000:A000 00000000000000000000000001000000:138F 01 0:0 00:0 0 1000 0 12 1\n   \
2: 0000000000000000FFFF00000100007F:A001 0000000000000000FFFF00000100007F:138F 01 0:0 00:0 0 1001 0 13 1\n";
        let user = |local: &str, remote: &str| {
            user_of(table, local.parse().unwrap(), remote.parse().unwrap())
        };
        assert_eq!(user("[::1]:40960", "[::1]:5007"), Some(1000));
        assert_eq!(user("127.0.0.1:40961", "127.0.0.1:5007"), Some(1001));
        assert_eq!(user("[::ffff:127.0.0.1]:40961", "[::ffff:127.0.0.1]:5007"), Some(1001));
        assert_eq!(user("127.0.0.1:40960", "127.0.0.1:5007"), None);
    }

    #[test]
    fn a_connection_of_this_process_is_that_of_its_user() {
        use std::{
            net::{TcpListener, TcpStream},
            os::unix::fs::MetadataExt as _,
        };
        for address in ["127.0.0.1:0", "[::1]:0"] {
            // Where the system has no IPv6, nobody connects by it.
            let Ok(listener) = TcpListener::bind(address) else { continue };
            let ours = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
            let (theirs, _) = listener.accept().unwrap();
            assert!(super::is_own(&theirs), "{address}");
            let ends = (theirs.peer_addr().unwrap(), theirs.local_addr().unwrap());
            let user = std::fs::metadata("/proc/self").map(|process| process.uid()).unwrap();
            assert_eq!(user_at(ends.0, ends.1), Some(user), "{address}");
            drop(ours);
        }
    }
}
