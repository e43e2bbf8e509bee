//! Components and programs that drive hardware or show a screen, with the beginnings of their pins.

use crate::language::command::DEVICES;

/// Kind of a known name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PartKind {
    /// A realtime module that drives hardware.
    Module,
    /// A program that drives hardware.
    Program,
    /// A program that shows something.
    Screen,
}

/// A known component or program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    /// Name in `loadrt` or `loadusr`.
    pub(crate) name: &'static str,
    pub(crate) kind: PartKind,
    /// Beginnings of its names, up to a dot. `*` at the end stands for any further letters.
    pub(crate) pins: &'static [&'static str],
}

const fn module(name: &'static str, pins: &'static [&'static str]) -> Known {
    Known { name, kind: PartKind::Module, pins }
}

const fn program(name: &'static str, pins: &'static [&'static str]) -> Known {
    Known { name, kind: PartKind::Program, pins }
}

const fn screen(name: &'static str, pins: &'static [&'static str]) -> Known {
    Known { name, kind: PartKind::Screen, pins }
}

/// Names as users' files have them; the second column is what `show pin` has for them.
const KNOWN: &[Known] = &[
    module("hostmot2", &[]),
    module("hm2_eth", &["hm2_*"]),
    module("hm2_pci", &["hm2_*"]),
    module("hm2_7i43", &["hm2_*"]),
    module("hm2_7i90", &["hm2_*"]),
    module("hm2_rpspi", &["hm2_*"]),
    module("hm2_spi", &["hm2_*"]),
    module("hm2_spix", &["hm2_*"]),
    module("hm2_modbus", &["hm2_modbus"]),
    module("lcec", &["lcec"]),
    module("cia402", &["cia402"]),
    module("hal_ppmc", &["ppmc"]),
    module("hal_motenc", &["motenc"]),
    module("hal_gm", &["gm"]),
    module("hal_stg", &["stg"]),
    module("hal_vti", &["vti"]),
    module("hal_evoreg", &["evoreg", "hal_evoreg"]),
    module("hal_ax5214h", &["ax5214h"]),
    module("hal_bb_gpio", &["bb_gpio"]),
    module("hal_gpiod", &["hal_gpio", "hal_gpiod"]),
    module("hal_pru_generic", &["hpg"]),
    module("hal_arm335xQEP", &["eQEP*"]),
    module("pluto_servo", &["pluto-servo"]),
    module("pluto_step", &["pluto-step"]),
    module("opto_ac5", &["opto-ac5", "opto_ac5"]),
    module("pcl720", &["pcl720"]),
    module("remora", &["remora"]),
    module("remora-eth-3.0", &["remora"]),
    module("remora-nv", &["remora"]),
    module("remora-spi", &["remora"]),
    module("rio", &["rio"]),
    module("litexcnc", &["litexcnc"]),
    module("litexcnc_eth", &["litexcnc"]),
    module("mesa_uart", &["mesa-uart", "mesa_uart"]),
    module("classicladder_rt", &["classicladder"]),
    module("serport", &["serport"]),
    module("hal_input", &["input"]),
    module("hy_vfd", &["hy_vfd"]),
    module("mb2hal", &["mb2hal"]),
    module("modbus", &["mb2hal"]),
    program("hy_gt_vfd", &["hy_gt_vfd"]),
    program("huanyang-vfd", &["huanyang-vfd"]),
    program("vfdmod", &["vfdmod", "spindle-vfd"]),
    program("vfdb_vfd", &["vfdb_vfd"]),
    program("vfs11_vfd", &["vfs11_vfd"]),
    program("gs2_vfd", &["gs2_vfd", "spindle-vfd"]),
    program("wj200_vfd", &["wj200-vfd", "wj200_vfd"]),
    program("mitsub_vfd", &["mitsub_vfd"]),
    program("svd-ps_vfd", &["svd-ps-vfd", "svd-ps_vfd"]),
    program("pmx485", &["pmx485"]),
    program("xhc-hb04", &["xhc-hb04"]),
    program("xhc-whb04b-6", &["whb", "xhc-whb04b-6"]),
    program("shuttle", &["shuttle", "shuttlexpress", "shuttlepro"]),
    program("shuttlexpress", &["shuttlexpress"]),
    program("lcec_conf", &["lcec_conf"]),
    program("ethercat-conf", &["lcec_conf"]),
    program("serial_port", &["serial"]),
    screen("axis", &["axisui", "pyvcp"]),
    screen("pyvcp", &["pyvcp"]),
    screen("gladevcp", &["gladevcp"]),
    screen("gmoccapy", &["gmoccapy"]),
    screen("gscreen", &["gscreen"]),
    screen("touchy", &["touchy"]),
    screen("qtvcp", &["qtvcp", "qtdragon", "qtplasmac", "qtaxis", "qttouchy", "qtlathe"]),
    screen("probe_basic", &["qtpyvcp"]),
    screen("probe_basic_lathe", &["qtpyvcp"]),
    screen("plasmac2", &["axisui", "plasmac"]),
    screen("qtpyvcp", &["qtpyvcp"]),
    screen("monokrom", &["qtpyvcp"]),
    screen("turbonc", &["qtpyvcp"]),
    screen("mdro", &["mdro"]),
    screen("lineardelta", &["lineardelta"]),
    screen("rotarydelta", &["rotarydelta"]),
    screen("halmeter", &[]),
    screen("halscope", &[]),
    screen("hal-histogram", &[]),
    screen("halshow", &[]),
    screen("classicladder", &[]),
];

/// Returns what is known of a name.
pub(crate) fn find(name: &str) -> Option<&'static Known> {
    KNOWN.iter().find(|known| known.name == name)
}

/// Returns whether a program is a view of a machine, as LinuxCNC's are, by its name.
pub(crate) fn is_view(name: &str) -> bool {
    let stem = name.strip_suffix(".py").unwrap_or(name);
    stem.ends_with("gui") || stem.ends_with("_vismach")
}

/// Returns whether a text names a program that a simulation replaces, or a module of hardware.
pub(crate) fn is_named_in(text: &[u8]) -> bool {
    let lines = text.split(|c| *c == b'\n').filter_map(|line| line.split(|c| *c == b'#').next());
    // An argument that names a device is one of such a program.
    let has = |device: &&str| text.windows(device.len()).any(|part| part == device.as_bytes());
    if DEVICES.iter().any(has) {
        return true;
    }
    lines.flat_map(|line| line.split(|c| c.is_ascii_whitespace() || *c == b'/')).any(|word| {
        let known = KNOWN.iter().find(|known| known.name.as_bytes() == word);
        let is_view = core::str::from_utf8(word).is_ok_and(is_view);
        is_view || known.is_some_and(|known| known.kind != PartKind::Module)
    })
}
