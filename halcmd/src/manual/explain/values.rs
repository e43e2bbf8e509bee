//! Explanations of findings about values that lines set.

use super::explanation::Explanation;
use hal_protocol::Code;

pub(super) const ROWS: &[Explanation] = &[
    Explanation {
        code: Code::NotWritable,
        means: "An output, a parameter that its component reports, a pin that is linked, or a \
                signal that an output writes cannot be set.",
        matters: "halrun stops at this line.",
        remedy: "Set an input or a parameter; of a linked pin, set the signal: sets SIGNAL VALUE.",
        wrong: "loadrt or2\nsetp or2.0.out 1 # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\n\
                setp or2.0.in0 1\nstart\n",
    },
    Explanation {
        code: Code::BadValue,
        means: "The value is not a value of the type, or does not fit into it.",
        matters: "halrun stops at this line.",
        remedy: "The sentence says what the type takes; 'halcmd ptype NAME' says the type.",
        wrong: "loadrt or2\nsetp or2.0.in0 maybe # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\n\
                setp or2.0.in0 TRUE\nstart\n",
    },
    Explanation {
        code: Code::SetTwice,
        means: "A line sets it to one value, a later one to another, and the machine does not run \
                in between.",
        matters: "The first line has no effect. Often one of the two is a mistake, such as a copied \
                  line whose number was not changed.",
        remedy: "Keep the one that is meant.",
        wrong: "loadrt stepgen step_type=0,0\nsetp stepgen.0.maxvel 10\n\
                setp stepgen.0.maxvel 20 # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt stepgen step_type=0,0\naddf stepgen.make-pulses servo\naddf stepgen.update-freq servo\n\
                setp stepgen.0.maxvel 10\nsetp stepgen.1.maxvel 20\nstart\n",
    },
    Explanation {
        code: Code::SetThenLinked,
        means: "A line sets the pin, and a later one links it to a signal that an output writes.",
        matters: "The value is lost with the link.",
        remedy: "Take the line out, or the link.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt or2 count=2\naddf or2.0 servo\n\
                addf or2.1 servo\nsetp or2.1.in0 1 # <--\nnet any or2.0.out => or2.1.in0\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2 count=2\naddf or2.0 servo\n\
                addf or2.1 servo\nsetp or2.1.in1 1\nnet any or2.0.out => or2.1.in0\nstart\n",
    },
    Explanation {
        code: Code::SetThenWritten,
        means: "A line sets the signal, and a later one links an output to it.",
        matters: "The output writes the signal in each cycle: the value is lost.",
        remedy: "Take the line out, or the output off the signal.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt or2 count=2\naddf or2.0 servo\n\
                addf or2.1 servo\nnet any or2.1.in0\nsets any 1 # <--\nnet any or2.0.out\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\n\
                loadrt keypad\nloadrt sim_handheld\naddf sim-handheld.update servo\naddf keypad.update servo\n\
                net any or2.0.in0\nsets any 1\nnewsig bytes port\nsets bytes 64\n\
                net bytes sim-handheld.frames keypad.frames-in\nstart\n",
    },
    Explanation {
        code: Code::ScaleZero,
        means: "A scale says how many steps, counts or volts make one unit, and it is 0.",
        matters: "Positions and speeds become 0, or what the component takes instead; following \
                  errors come from nowhere.",
        remedy: "Set what one unit is; a negative scale turns the direction round.",
        wrong: "loadrt stepgen step_type=0\nsetp stepgen.0.position-scale 0 # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt stepgen step_type=0\naddf stepgen.make-pulses servo\naddf stepgen.update-freq servo\n\
                setp stepgen.0.position-scale -80\nstart\n",
    },
    Explanation {
        code: Code::BoundsCross,
        means: "The lower bound of a range is above the upper one.",
        matters: "Nothing is within such a range: the output stays at one of the bounds.",
        remedy: "Swap them, or correct the one that is wrong.",
        wrong: "loadrt limit1\nsetp limit1.0.max -5\nsetp limit1.0.min 5 # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt limit1\naddf limit1.0 servo\n\
                setp limit1.0.max 5\nsetp limit1.0.min -5\nstart\n",
    },
    Explanation {
        code: Code::EarlierValue,
        means: "The item is neither set nor linked, and its first value is that of LinuxCNC 2.10, which is another \
                one in 2.9.",
        matters: "A machine from 2.9 behaves otherwise here: limit3 accelerates less, a switch counts later.",
        remedy: "Set the item to what is meant. HAL_COMPAT=2.9, or COMPAT = 2.9 in section HAL of the INI file, gives \
                 all values of 2.9.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt limit3 # <--\naddf limit3.0 servo\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt limit3\naddf limit3.0 servo\n\
                setp limit3.0.maxa 1e20\nstart\n",
    },
    Explanation {
        code: Code::NotFinite,
        means: "The value is nan, which is not a number, or infinite where no bound is set.",
        matters: "Every result that is computed from it is no number either; comparisons with it are never \
                  true.",
        remedy: "Write a number.",
        wrong: "loadrt limit1\nsetp limit1.0.max nan # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt limit1\naddf limit1.0 servo\n\
                setp limit1.0.max 5\nsetp limit1.0.min -5\nstart\n",
    },
];
