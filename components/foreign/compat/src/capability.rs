//! Capability of the process that a module without permission lacks, by what the module imports.

use core::ffi::c_int;
use std::ffi::CString;

/// Functions, and what their use needs: the number of the capability, and the end of the message.
const NEEDS: &[(&str, u32, &str)] = &[
    (
        "socket",
        12,
        "; this process lacks CAP_NET_ADMIN, which it takes to set addresses and rules of a network card: \
         `sudo setpriv --reuid \"$USER\" --regid \"$(id -g)\" --init-groups --inh-caps +net_admin,+net_raw \
         --ambient-caps +net_admin,+net_raw halrun FILE`",
    ),
    ("ioperm", 17, RAW_IO),
    ("iopl", 17, RAW_IO),
    ("rtapi_open_as_root", 17, RAW_IO),
];

const RAW_IO: &str = "; this process lacks CAP_SYS_RAWIO, which it takes to use ports and memory of cards: \
                      `sudo setpriv --reuid \"$USER\" --regid \"$(id -g)\" --init-groups --inh-caps +sys_rawio \
                      --ambient-caps +sys_rawio halrun FILE`";

/// Returns the end of the message of a setup that failed with this code, or nothing.
pub(crate) fn lacking(code: c_int, imports: &[CString]) -> &'static str {
    if code != -libc::EPERM && code != -libc::EACCES {
        return "";
    }
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    missing(&status, imports)
}

fn missing(status: &str, imports: &[CString]) -> &'static str {
    let has = status.lines().find_map(|line| line.strip_prefix("CapEff:"));
    let Some(has) = has.and_then(|text| u64::from_str_radix(text.trim(), 16).ok()) else {
        return "";
    };
    let needed = NEEDS.iter().find(|(function, number, _)| {
        has >> number & 1 == 0 && imports.iter().any(|i| i.to_bytes() == function.as_bytes())
    });
    needed.map_or("", |(_, _, text)| text)
}

#[cfg(test)]
mod tests {
    use super::{NEEDS, lacking, missing};
    use std::ffi::CString;

    #[test]
    fn by_import_and_by_what_the_process_has() {
        let card = [CString::from(c"printf"), CString::from(c"socket")];
        let ports = [CString::from(c"iopl")];
        for (_, _, text) in NEEDS {
            // File capabilities (`setcap`) would give the right to everybody, and a program that has them opens no plugin.
            assert!(text.contains("sudo setpriv --reuid") && !text.contains("setcap"), "{text}");
        }
        let none = "Name:\thalrun\nCapEff:\t0000000000000000\n";
        let all = "CapEff:\t000001ffffffffff\n";
        assert!(missing(none, &card).contains("CAP_NET_ADMIN"));
        assert!(missing(none, &ports).contains("CAP_SYS_RAWIO"));
        for (status, imports) in [(all, &card[..]), (none, &card[..1]), ("", &card[..])] {
            assert_eq!(missing(status, imports), "");
        }
        assert_eq!(lacking(-libc::ENODEV, &card), "");
    }
}
