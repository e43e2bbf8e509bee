//! Explanations of findings about channels that are wired in half, not at all, or to each other.

use super::explanation::Explanation;
use hal_protocol::Code;

/// Two joints and their step generators. The arguments are the first lines, the feedback lines of X and of Y, and
/// the last lines.
macro_rules! joints {
    ($first:literal, $x:literal, $y:literal, $last:literal) => {
        concat!(
            $first,
            "loadrt trivkins coordinates=XY\n",
            "loadrt motmod num_joints=2 base_period_nsec=100000\n",
            "loadrt stepgen step_type=0,0\n",
            "addf stepgen.make-pulses base-thread\n",
            "addf stepgen.capture-position servo-thread\n",
            "addf motion-command-handler servo-thread\n",
            "addf motion-controller servo-thread\n",
            "addf stepgen.update-freq servo-thread\n",
            "net x-on joint.0.amp-enable-out => stepgen.0.enable\n",
            "net y-on joint.1.amp-enable-out => stepgen.1.enable\n",
            "net x joint.0.motor-pos-cmd => stepgen.0.position-cmd\n",
            $x,
            "net y joint.1.motor-pos-cmd => stepgen.1.position-cmd\n",
            $y,
            $last
        )
    };
}

pub(super) const ROWS: &[Explanation] = &[
    Explanation {
        code: Code::HalfWired,
        means: "A pin is linked, and a pin of the same channel that it is useless without is not.",
        matters: "Steps without a direction go one way, a command without feedback is a following \
                  error, and a channel that is never enabled stands still.",
        remedy: "Link the other pin too, or give it its value.",
        wrong: "loadrt trivkins\nloadrt motmod num_joints=1\naddf motion-command-handler servo-thread\n\
                addf motion-controller servo-thread\nloadrt scale\naddf scale.0 servo-thread\n\
                net x joint.0.motor-pos-cmd => scale.0.in # <--\nnet y scale.0.out\n",
        right: "loadrt iocontrol interlock=1\nloadrt trivkins\nloadrt motmod num_joints=1\naddf motion-command-handler servo-thread\n\
                addf motion-controller servo-thread\n\
                net x joint.0.motor-pos-cmd => joint.0.motor-pos-fb\n\
                net estop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\n",
    },
    Explanation {
        code: Code::InputOpen,
        means: "An input on which a channel works has no signal and no value, and other pins of the \
                channel are in use.",
        matters: "It keeps the value that it began with: an and2 is never TRUE, a filter stays at 0.",
        remedy: "Link it, or say its value with setp.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt siggen\nloadrt and2\nloadrt comp\n\
                addf siggen.0.update servo\naddf comp.0 servo\naddf and2.0 servo\n\
                net wave siggen.0.sine => comp.0.in1\nnet high comp.0.out => and2.0.in0 # <--\n\
                net both and2.0.out\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt siggen\nloadrt and2\nloadrt comp\n\
                addf siggen.0.update servo\naddf comp.0 servo\naddf and2.0 servo\n\
                net wave siggen.0.sine => comp.0.in1\nnet high comp.0.out => and2.0.in0\n\
                setp and2.0.in1 1\nnet both and2.0.out\nstart\n",
    },
    Explanation {
        code: Code::ResultUnused,
        means: "A channel works on an input, and no output of it is linked.",
        matters: "What it computes goes nowhere: the line that uses it was probably forgotten.",
        remedy: "Link an output, or take the channel out.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt siggen\nloadrt lowpass\n\
                addf siggen.0.update servo\naddf lowpass.0 servo\n\
                net wave siggen.0.sine => lowpass.0.in # <--\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt siggen\nloadrt lowpass\n\
                addf siggen.0.update servo\naddf lowpass.0 servo\n\
                net wave siggen.0.sine => lowpass.0.in\nnet smooth lowpass.0.out\nstart\n",
    },
    Explanation {
        code: Code::OddChannel,
        means: "Every channel in use but this one has the pin linked, or the parameter set.",
        matters: "The line for this channel was probably forgotten: its scale is 1, its motor is \
                  never enabled.",
        remedy: "Write the line for this channel too, or allow it with a comment.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt pwmgen output_type=0,0 # <--\n\
                addf pwmgen.make-pulses servo\naddf pwmgen.update servo\nsetp pwmgen.0.scale 10\n\
                setp pwmgen.0.value 1\nsetp pwmgen.0.enable 1\nsetp pwmgen.1.value 1\n\
                setp pwmgen.1.enable 1\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt pwmgen output_type=0,0\n\
                addf pwmgen.make-pulses servo\naddf pwmgen.update servo\nsetp pwmgen.0.scale 10\n\
                setp pwmgen.1.scale 10\nsetp pwmgen.0.value 1\nsetp pwmgen.0.enable 1\n\
                setp pwmgen.1.value 1\nsetp pwmgen.1.enable 1\nstart\n",
    },
    Explanation {
        code: Code::Crossed,
        means: "A joint gets its feedback from another channel than the one that it commands, one of \
                several signals with the same beginning goes to another channel than the rest, or two \
                channels each read a signal of one axis and write one of the other.",
        matters: "Two motors follow each other's commands, or a following error stops both.",
        remedy: "Exchange the two.",
        wrong: joints!(
            "",
            "net x-fb stepgen.1.position-fb => joint.0.motor-pos-fb # <--\n",
            "net y-fb stepgen.0.position-fb => joint.1.motor-pos-fb\n",
            ""
        ),
        right: joints!(
            "loadrt iocontrol interlock=1\n",
            "net x-fb stepgen.0.position-fb => joint.0.motor-pos-fb\n",
            "net y-fb stepgen.1.position-fb => joint.1.motor-pos-fb\n",
            "net estop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\n"
        ),
    },
    Explanation {
        code: Code::ArrowTurned,
        means: "The arrow of a net line points from an input to an output.",
        matters: "Nothing at all: arrows only tell readers. But this one says the opposite, and \
                  the pins may be the wrong ones.",
        remedy: "Turn the arrow round, or correct the pins.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt siggen\nloadrt lowpass\n\
                addf siggen.0.update servo\naddf lowpass.0 servo\n\
                net wave lowpass.0.in => siggen.0.sine # <--\nnet smooth lowpass.0.out\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt siggen\nloadrt lowpass\n\
                addf siggen.0.update servo\naddf lowpass.0 servo\n\
                net wave lowpass.0.in <= siggen.0.sine\nnet smooth lowpass.0.out\nstart\n",
    },
    Explanation {
        code: Code::SignalMisspelt,
        means: "The signal has only outputs or only inputs, and its name differs by one typing error from \
                that of a signal which has the other end.",
        matters: "The two are not joined: the input stays at its value.",
        remedy: "Write the same name in both lines.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt or2 count=2\naddf or2.0 servo\n\
                addf or2.1 servo\nnet lamp-on or2.0.out\nnet lamp-no or2.1.in0 # <--\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2 count=2\naddf or2.0 servo\n\
                addf or2.1 servo\nnet lamp-on or2.0.out\nnet lamp-on or2.1.in0\nstart\n",
    },
];
