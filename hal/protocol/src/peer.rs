//! The process at the other end of a connection, as the kernel knows it.

use std::os::fd::{AsFd, AsRawFd};

/// Returns the user id of the process at the other end of a connection, as the kernel recorded it
/// when that process connected or began to listen.
///
/// # Errors
/// The system call failed.
pub fn peer(socket: impl AsFd) -> std::io::Result<u32> {
    Ok(credentials(socket)?.uid)
}

/// Returns the process id of that process, as this process sees it: 0 if it cannot.
///
/// # Errors
/// The system call failed.
pub fn peer_process(socket: impl AsFd) -> std::io::Result<i32> {
    Ok(credentials(socket)?.pid)
}

fn credentials(socket: impl AsFd) -> std::io::Result<libc::ucred> {
    let mut peer = libc::ucred { pid: 0, uid: u32::MAX, gid: u32::MAX };
    let mut size = libc::socklen_t::try_from(size_of::<libc::ucred>()).unwrap_or(0);
    // SAFETY: the kernel writes at most `size` bytes; `peer` and `size` live across the call.
    let status = unsafe {
        libc::getsockopt(
            socket.as_fd().as_raw_fd(),
            libc::SOL_SOCKET,
            libc::SO_PEERCRED,
            (&raw mut peer).cast(),
            &raw mut size,
        )
    };
    if status == 0 { Ok(peer) } else { Err(std::io::Error::last_os_error()) }
}
