//! Other users, for tests that run as root: a thread can become one, and the process stays root.

use crate::tools;
use rustix::{
    process::{Gid, Uid},
    thread::{set_thread_groups, set_thread_res_gid, set_thread_res_uid},
};

/// User id of root.
pub const ROOT: u32 = 0;

/// Returns whether this process runs as root; if not, reports the running test as skipped.
pub fn is_root() -> bool {
    let is_root = rustix::process::geteuid().is_root();
    if !is_root {
        tools::report("only root can be several users");
    }
    is_root
}

/// Runs a function as another user, in a thread of its own.
pub fn as_user<T: Send>(user: u32, work: impl FnOnce() -> T + Send) -> T {
    let become_user = move || {
        let (uid, gid) = (Uid::from_raw(user), Gid::from_raw(user));
        set_thread_groups(&[]).unwrap();
        set_thread_res_gid(gid, gid, gid).unwrap();
        set_thread_res_uid(uid, uid, uid).unwrap();
    };
    let work = move || {
        become_user();
        work()
    };
    std::thread::scope(|scope| scope.spawn(work).join().unwrap())
}
