//! Explanations of findings about signals and pins.

use super::explanation::Explanation;
use hal_protocol::Code;

pub(super) const ROWS: &[Explanation] = &[
    Explanation {
        code: Code::TypeMismatch,
        means: "A signal joins pins of one type, and this one has another.",
        matters: "halrun stops at this line.",
        remedy: "Join another pin, or put a converter between them, such as conv_float_s32.",
        wrong: "loadrt or2\nloadrt siggen\nnet wave siggen.0.sine\nnet wave or2.0.in0 # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\nloadrt siggen\n\
                loadrt comp\naddf siggen.0.update servo\naddf comp.0 servo\naddf or2.0 servo\n\
                net wave siggen.0.sine => comp.0.in0\nnet high comp.0.out => or2.0.in0\nstart\n",
    },
    Explanation {
        code: Code::TwoWriters,
        means: "The signal has an output already. One signal has one writer.",
        matters: "halrun stops at this line. If it did not, each writer would undo the other.",
        remedy: "Decide between them with a component such as or2, mux2 or sum2.",
        wrong: "loadrt or2 count=2\nnet any or2.0.out\nnet any or2.1.out # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2 count=3\n\
                addf or2.0 servo\naddf or2.1 servo\naddf or2.2 servo\n\
                net a or2.0.out => or2.2.in0\nnet b or2.1.out => or2.2.in1\nstart\n",
    },
    Explanation {
        code: Code::LinkedTwice,
        means: "The pin is linked to another signal. A pin has one signal.",
        matters: "halrun stops at this line.",
        remedy: "Use the signal that the pin has, or unlink it first: unlinkp PIN.",
        wrong: "loadrt or2\nnet a or2.0.in0\nnet b or2.0.in0 # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\n\
                net a or2.0.in0\nnet b or2.0.in1\nstart\n",
    },
    Explanation {
        code: Code::NamedAsPin,
        means: "The first word after net is the name of the signal, and a pin has that name: the \
                signal was probably forgotten.",
        matters: "halrun stops at this line.",
        remedy: "Write the signal's name first: net SIGNAL PIN => PIN.",
        wrong: "loadrt or2 count=2\nnet or2.0.out => or2.1.in0 # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2 count=2\naddf or2.0 servo\n\
                addf or2.1 servo\nnet any or2.0.out => or2.1.in0\nstart\n",
    },
    Explanation {
        code: Code::PortMisused,
        means: "A signal of type port has one writer and one reader, and its size is set once.",
        matters: "halrun stops at this line.",
        remedy: "One reader for each port; sets once, before the threads start.",
        wrong: "newsig bytes port\nsets bytes 100\nsets bytes 200 # <--\n",
        right: "newsig bytes port\nsets bytes 200\n",
    },
    Explanation {
        code: Code::NoReader,
        means: "An output is linked to the signal, and no input.",
        matters: "Whatever the output says goes nowhere. That is fine for a signal that people \
                  watch, and a mistake for one that a motor should follow. It is a warning if the \
                  name is nearly that of another signal.",
        remedy: "Link an input to it, or take it out.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\n\
                net any or2.0.out # <--\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2 count=2\naddf or2.0 servo\n\
                addf or2.1 servo\nnet any or2.0.out => or2.1.in0\nstart\n",
    },
    Explanation {
        code: Code::NoWriter,
        means: "Inputs are linked to the signal, no output is, and no line gives it a value.",
        matters: "It keeps the value that the first input had. A limit switch that ends like this \
                  never stops an axis. It is a warning if the name is nearly that of another \
                  signal.",
        remedy: "Link the output that should write it, or give it its value: sets SIGNAL VALUE.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\n\
                net any or2.0.in0 # <--\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\n\
                net any or2.0.in0\nsets any 1\nstart\n",
    },
    Explanation {
        code: Code::Unguarded,
        means: "An input for a limit switch, a fault or the e-stop has no signal and no value of \
                its own.",
        matters: "It never says anything: what it should protect is not protected.",
        remedy: "Link the switches that the machine has.",
        wrong: "loadrt estop_latch # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\nloadrt estop_latch\n\
                addf or2.0 servo\naddf estop-latch.0 servo\n\
                net ok or2.0.out => estop-latch.0.ok-in\nsetp estop-latch.0.reset 1\n\
                net good estop-latch.0.ok-out\nstart\n",
    },
    Explanation {
        code: Code::NeverEnabled,
        means: "iocontrol waits for emc-enable-in to be TRUE, and nothing can make it so.",
        matters: "The machine never leaves e-stop.",
        remedy: "Link it to the e-stop chain; without one, to user-enable-out.",
        wrong: "loadrt iocontrol # <--\n",
        right: "loadrt iocontrol\n\
                net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\n",
    },
    Explanation {
        code: Code::Unfed,
        means: "A driver's output has no signal, and no line has set it.",
        matters: "The line stays at the level of FALSE. If a motor is wired to it, it does not \
                  move.",
        remedy: "Link it, if something is wired to it.",
        wrong: "loadrt hal_viagpio # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt hal_viagpio\nloadrt or2\n\
                addf or2.0 servo\naddf viagpio.write servo\n\
                net lamp or2.0.out => viagpio.pin-05-out viagpio.pin-06-out\n\
                net lamp => viagpio.pin-07-out viagpio.pin-08-out\nstart\n",
    },
    Explanation {
        code: Code::NoPins,
        means: "The signal was made, and no pin is linked to it.",
        matters: "It does nothing. Its name may be misspelt where it is used.",
        remedy: "Link pins to it, or take it out.",
        wrong: "newsig any bit # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\n\
                newsig any bit\nlinksp any or2.0.in0\nstart\n",
    },
    Explanation {
        code: Code::NoChargePump,
        means: "A driver's outputs are used, and no charge pump beats.",
        matters: "After a crash of the computer, or kill -9, outputs keep their last level. A board \
                  with an input for a charge pump switches off when the beat stops.",
        remedy: "If the board has such an input: loadrt charge_pump, addf charge-pump to the \
                 fastest thread, and link charge-pump.out to the output.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt hal_viagpio # <--\nloadrt or2\n\
                addf or2.0 servo\naddf viagpio.write servo\n\
                net lamp or2.0.out => viagpio.pin-05-out\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt hal_viagpio\nloadrt or2\n\
                loadrt charge_pump\naddf or2.0 servo\naddf charge-pump servo\n\
                addf viagpio.write servo\nnet lamp or2.0.out => viagpio.pin-05-out\n\
                net pump charge-pump.out => viagpio.pin-06-out\nstart\n",
    },
    Explanation {
        code: Code::EstopNotReturned,
        means: "iocontrol.0.user-enable-out goes FALSE with iocontrol.estop, and no signal or \
                component carries that back to iocontrol.0.emc-enable-in.",
        matters: "The chain of e-stop contacts stays closed in an e-stop that is commanded: what \
                  hangs at it goes on, and iocontrol.estop fails.",
        remedy: "Let it open the chain: directly, or by an and2 with the button before the latch.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt iocontrol\nloadrt or2\n\
                addf or2.0 servo\nnet closed or2.0.out => iocontrol.0.emc-enable-in\n\
                net allowed iocontrol.0.user-enable-out # <--\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt iocontrol\nloadrt or2\n\
                loadrt and2\naddf or2.0 servo\naddf and2.0 servo\n\
                net button or2.0.out => and2.0.in0\n\
                net allowed iocontrol.0.user-enable-out => and2.0.in1\n\
                net closed and2.0.out => iocontrol.0.emc-enable-in\nstart\n",
    },
    Explanation {
        code: Code::EstopNotJoined,
        means: "A script has no INI file, so it stops motion in e-stop by its own signals; and \
                motion.enable follows neither user-enable-out nor the e-stop chain, or \
                user-enable-out alone, or nothing at all.",
        matters: "Motion goes on in e-stop.",
        remedy: "Link motion.enable to the signal of emc-enable-in; or load iocontrol with \
                 interlock=1 before motmod, which then stops whatever is wired.",
        wrong: "loadrt iocontrol\nloadrt trivkins\nloadrt motmod num_joints=1 # <--\n\
                addf motion-command-handler servo-thread\naddf motion-controller servo-thread\n\
                net x joint.0.motor-pos-cmd => joint.0.motor-pos-fb\n\
                net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\nstart\n",
        right: "loadrt iocontrol interlock=1\nloadrt trivkins\nloadrt motmod num_joints=1\n\
                addf motion-command-handler servo-thread\naddf motion-controller servo-thread\n\
                net x joint.0.motor-pos-cmd => joint.0.motor-pos-fb\n\
                net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\nstart\n",
    },
];
