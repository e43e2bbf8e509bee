//! Functions `rtapi_spawn_as_root` and `rtapi_spawnp_as_root`: no component runs a program here. On the real clock the
//! component gets a child that has failed, so that it can go on without what the program would have done, and the log
//! has the command, which a person can run.

use crate::{outside, pin::text, running};
use core::ffi::{c_char, c_int, c_long, c_void};
use hal_component::abi::level;
use std::sync::atomic::Ordering::Relaxed;

#[unsafe(no_mangle)]
extern "C" fn rtapi_spawn_as_root(
    pid: *mut libc::pid_t,
    path: *const c_char,
    _actions: *const c_void,
    _attributes: *const c_void,
    arguments: *const *const c_char,
    _environment: *const *mut c_char,
) -> c_int {
    if running::module().is_none_or(crate::module::Module::is_simulated) {
        outside::note("rtapi_spawn_as_root", text(path).unwrap_or_default());
        // This process is no child of its own: a component that waits for it gets that answer at once.
        // SAFETY: queries a number.
        store(pid, unsafe { libc::getpid() });
        return libc::EPERM;
    }
    let words = words(path, arguments);
    if let Some(m) = running::module() {
        m.say(level::NOTICE, &format!("not run: {}", command(&words)));
        if !m.told_refusal.swap(true, Relaxed) {
            m.say(level::NOTICE, remedy(&words));
        }
    }
    // SAFETY: the copy ends at once.
    let child = unsafe { libc::fork() };
    if child == 0 {
        let failed: c_long = 1;
        // SAFETY: ends the copy with nothing run in it.
        unsafe { libc::syscall(libc::SYS_exit_group, failed) };
    }
    if child < 0 {
        return std::io::Error::last_os_error().raw_os_error().unwrap_or(libc::EAGAIN);
    }
    store(pid, child);
    0
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_spawnp_as_root(
    pid: *mut libc::pid_t,
    path: *const c_char,
    actions: *const c_void,
    attributes: *const c_void,
    arguments: *const *const c_char,
    environment: *const *mut c_char,
) -> c_int {
    rtapi_spawn_as_root(pid, path, actions, attributes, arguments, environment)
}

fn store(pid: *mut libc::pid_t, value: libc::pid_t) {
    if !pid.is_null() {
        // SAFETY: the component's memory for a process number.
        unsafe { pid.write(value) };
    }
}

/// Returns the words of the command: those after the program's own name, behind its path.
fn words(path: *const c_char, arguments: *const *const c_char) -> Vec<String> {
    let mut all = vec![text(path).unwrap_or("?").to_owned()];
    for i in 1..64 {
        if arguments.is_null() {
            break;
        }
        // SAFETY: the component passes a list that ends with a null pointer, which was not reached yet.
        let word = unsafe { arguments.wrapping_add(i).read() };
        if word.is_null() {
            break;
        }
        all.push(text(word).unwrap_or("?").to_owned());
    }
    all
}

/// Returns a command as a person types it. What a shell would have run stands there without the shell.
fn command(words: &[String]) -> String {
    if let [shell, option, line, ..] = words
        && (shell.ends_with("/sh") || shell.ends_with("/bash") || shell == "sh")
        && option == "-c"
    {
        return line.trim().to_owned();
    }
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+@%".contains(c);
    let quoted = words.iter().map(|word| {
        if !word.is_empty() && word.chars().all(plain) {
            word.clone()
        } else {
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    });
    quoted.collect::<Vec<_>>().join(" ")
}

/// Returns what a person can do instead.
fn remedy(words: &[String]) -> &'static str {
    if command(words).contains("iptables") {
        "no firewall rule keeps other packets off the card's wire; to set one, as root, which needs CAP_NET_ADMIN and \
         CAP_NET_RAW: iptables -A OUTPUT -o IFACE -p udp -d BOARD_IP --dport 27181 -j ACCEPT && iptables -A OUTPUT \
         -o IFACE -j REJECT"
    } else {
        "components run no programs here; run it as root before the start if it is needed"
    }
}

#[cfg(test)]
mod tests {
    use super::{command, remedy, words};
    use core::ptr::null;

    fn owned(words: &[&str]) -> Vec<String> {
        words.iter().map(|w| (*w).to_owned()).collect()
    }

    #[test]
    fn commands_as_typed() {
        for (given, typed) in [
            (&["/sbin/modprobe", "spi-bcm2835"][..], "/sbin/modprobe spi-bcm2835"),
            (&["/bin/sh", "-c", " iptables -N x "], "iptables -N x"),
            (&["/bin/echo", "a b", "it's", ""], "/bin/echo 'a b' 'it'\\''s' ''"),
        ] {
            assert_eq!(command(&owned(given)), typed);
        }
    }

    #[test]
    fn the_rule_is_named_for_a_firewall_only() {
        let rule = remedy(&owned(&["/bin/sh", "-c", "iptables -N x"]));
        assert!(rule.contains("iptables -A OUTPUT") && rule.contains("CAP_NET_ADMIN"), "{rule}");
        assert!(!remedy(&owned(&["/sbin/modprobe"])).contains("iptables"));
    }

    #[test]
    fn the_list_ends_with_null() {
        let list = [c"sh".as_ptr(), c"-c".as_ptr(), c"true".as_ptr(), null()];
        let found = words(c"/bin/sh".as_ptr(), list.as_ptr());
        assert_eq!(found, ["/bin/sh", "-c", "true"]);
        assert_eq!(words(c"/bin/true".as_ptr(), null()), ["/bin/true"]);
    }
}
