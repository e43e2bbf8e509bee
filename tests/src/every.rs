//! Every component that a library offers, with the arguments used by tests that load all of them.

use crate::programs::programs;
use hal_engine::{ClockKind, Engine, Offer, Options};
use hal_protocol::Place;

/// Arguments that a component requires, or that give it more pins; one entry for each variant.
const WAYS: &[(&str, &[&str])] = &[
    ("and2", &["count=4"]),
    ("bitslice", &["personality=32"]),
    ("bldc", &["cfg=hH,q6"]),
    ("debounce", &["cfg=1,4,2"]),
    ("demux", &["personality=9"]),
    ("demux_generic", &["config=ff4,bu3"]),
    ("enum", &["enums=E;;a;b,D;;c;d"]),
    ("gantry", &["personality=3"]),
    (
        "hal_gpio",
        &[
            "inputs=A,B,C outputs=D,E,F activelow=C invert=F reset=D,E debounce=B:1500 encoders=G:H:I,J",
        ],
    ),
    ("hal_input", &["devices=X-Box,PRO,keyboard"]),
    ("hal_parport", &["cfg=378_out_278_in_3bc_x"]),
    ("lcd", &["fmt_strings=X%7.2f\\n%i|%u%b01%c,page"]),
    ("lcd_reader", &["find=IDLE,RUN values=X,Y,Z"]),
    ("logic", &["count=2 personality=0x704,0x310"]),
    ("matrix_kb", &["config=2x3,4x8s"]),
    ("max31855", &["personality=3"]),
    ("message", &["messages=hello"]),
    ("modmath", &["mod_dir=2"]),
    ("motmod", &["base_period_nsec=100000 servo_period_nsec=500000 num_joints=3"]),
    ("sampler", &["depth=50,7 cfg=fbsulk,bb"]),
    ("mux_generic", &["config=ff8,fb5,bs4,uf6"]),
    ("pid", &["num_chan=2 debug=1"]),
    ("pwmgen", &["output_type=0,1,2"]),
    // Without a name of its own, its pins collide with those of motion's spindles.
    ("spindle", &["names=gears numgears=3"]),
    (
        "stepgen",
        &[
            "step_type=0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15 user_step_type=1,2,4,8",
            "step_type=0,0,2,5 ctrl_type=v,p,v,p",
        ],
    ),
    ("streamer", &["depth=50,7 cfg=fbsulk,bb"]),
    ("threads", &["name1=also period1=1000000"]),
    ("watchdog", &["num_inputs=3"]),
    ("weighted_sum", &["wsum_sizes=3,16"]),
];

/// An argument that makes an instance large.
enum Size {
    /// `ARG=VALUE,VALUE,…`, one value for each instance, at most this many.
    Each(&'static str, &'static str, usize),
    /// `ARG=N`, at most this many.
    Number(&'static str, usize),
    /// A fixed text.
    Fixed(&'static str),
}

/// The largest size of each component that grows with its arguments.
const LARGE: &[(&str, &[Size])] = {
    use Size::{Each, Fixed, Number};
    const ANY: usize = usize::MAX;
    &[
        ("at_pid", &[Number("num_chan", 16)]),
        ("bitmerge", &[Each("personality", "32", ANY)]),
        ("bitslice", &[Each("personality", "32", ANY)]),
        ("bldc", &[Each("cfg", "qiB", 8)]),
        ("counter", &[Number("num_chan", 8)]),
        ("debounce", &[Each("cfg", "50", 8)]),
        ("demux", &[Each("personality", "32", ANY)]),
        ("demux_generic", &[Each("config", "ff32", 100)]),
        ("encoder", &[Number("num_chan", 8)]),
        ("encoder_ratio", &[Number("num_chan", 8)]),
        ("enum", &[Each("enums", "E;;a;b;c;d;e;f;g;h", 16)]),
        ("gantry", &[Each("personality", "7", ANY)]),
        (
            "hal_gpio",
            &[Fixed(
                "inputs=A0,A1,A2,A3,A4,A5,A6,A7,A8,A9,B0,B1,B2,B3,B4,B5 \
                 outputs=C0,C1,C2,C3,C4,C5,C6,C7,C8,C9,D0,D1,D2,D3,D4,D5 reset=C0,C2,C4 \
                 encoders=E0:E1:E2,F0:F1:F2,G0:G1,H0",
            )],
        ),
        ("hal_input", &[Fixed("devices=X-Box,Dual,PRO,Mouse,keyboard")]),
        (
            "hal_parport",
            &[Fixed("cfg=278_out_378_out_3bc_x_2bc_in_1278_in_1378_x_13bc_x_12bc_epp")],
        ),
        ("lcd", &[Each("fmt_strings", "%7.2f%7.2f%i%u%b01", 16)]),
        ("lcd_reader", &[Fixed("find=a,b,c,d,e,f,g,h values=A,B,C,D,E,F,G,H,I,J,K,L,M,N,O,P")]),
        ("limit_axis", &[Each("personality", "10", ANY)]),
        ("lincurve", &[Each("personality", "16", ANY)]),
        ("logic", &[Each("personality", "0x710", ANY)]),
        ("matrix_kb", &[Each("config", "16x32s", 32)]),
        ("message", &[Each("messages", "hello", ANY)]),
        ("modmath", &[Number("mod_dir", 16)]),
        ("motmod", &[Fixed("base_period_nsec=500000 servo_period_nsec=1000000 num_joints=9")]),
        ("multiswitch", &[Each("cfg", "32", 16)]),
        ("mux_generic", &[Each("config", "ff32", 100)]),
        ("output_buffer", &[Each("personality", "10", ANY)]),
        ("pid", &[Number("num_chan", 16), Fixed("debug=1")]),
        ("pwmgen", &[Each("output_type", "1", 8)]),
        ("radiobutton", &[Each("personality", "32", ANY)]),
        ("sampler", &[Each("depth", "1000", 8), Each("cfg", "fffffffffffffffffffff", 8)]),
        ("siggen", &[Number("num_chan", 16)]),
        ("sim_encoder", &[Number("num_chan", 8)]),
        ("spindle", &[Fixed("numgears=16")]),
        ("stepgen", &[Each("step_type", "2", 16)]),
        ("streamer", &[Each("depth", "1000", 8), Each("cfg", "fffffffffffffffffffff", 8)]),
        ("supply", &[Number("num_chan", 8)]),
        (
            "threads",
            &[Fixed("name1=a period1=1000000 name2=b period2=2000000 name3=c period3=3000000")],
        ),
        ("watchdog", &[Number("num_inputs", 32)]),
        ("weighted_sum", &[Each("wsum_sizes", "16", 8)]),
    ]
};

/// Returns an engine on the virtual clock that finds every plugin.
pub fn engine() -> Engine {
    Engine::without_socket(Options {
        path: vec![programs().to_owned()],
        realtime: crate::machine::realtime(),
        ..Options::simulated(Place::at("/nonexistent", "every").unwrap(), ClockKind::Virtual)
    })
    .unwrap()
}

/// Returns the offers of every library.
pub fn offers() -> Vec<Offer> {
    let offers = engine().catalogue();
    assert!(offers.len() > 150, "every library of components/ is there: {}", offers.len());
    offers
}

/// Returns the arguments with which tests load a component, one entry for each variant.
pub fn ways(component: &str) -> &'static [&'static str] {
    WAYS.iter().find(|(name, _)| *name == component).map_or(&[""], |(_, ways)| ways)
}

/// Returns whether the component needs a motion controller that is loaded before it.
pub fn needs_motion(component: &str) -> bool {
    ["halui", "inihal", "remote"].contains(&component)
}

/// Returns the place of a component in an order of loads: kinematics before motion, and motion before what needs it.
pub fn order(component: &str) -> u32 {
    match component {
        "trivkins" => 0,
        other if needs_motion(other) => 2,
        _ => 1,
    }
}

/// Returns whether the component creates one instance for each of `count=`.
pub fn is_counted(offer: &Offer) -> bool {
    // The kinematics component has an unrelated argument of that name.
    offer.library != "kinematics" && offer.args.iter().any(|a| a.name == "count")
}

/// Returns the arguments for this many instances, each of the largest size, or for as many as one load can create.
pub fn large(offer: &Offer, count: usize) -> String {
    let mut words = Vec::new();
    if is_counted(offer) {
        words.push(format!("count={count}"));
    }
    let sizes = LARGE.iter().find(|(name, _)| *name == offer.component);
    for size in sizes.map_or(&[][..], |(_, sizes)| sizes) {
        words.push(match *size {
            Size::Each(arg, value, most) => {
                format!("{arg}={}", vec![value; count.min(most)].join(","))
            }
            Size::Number(arg, most) => format!("{arg}={}", count.min(most)),
            Size::Fixed(words) => words.to_owned(),
        });
    }
    words.join(" ")
}
