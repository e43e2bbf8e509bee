//! Explanations of findings about functions and threads.

use super::explanation::Explanation;
use hal_protocol::Code;

pub(super) const ROWS: &[Explanation] = &[
    Explanation {
        code: Code::NeverAdded,
        means: "Pins of the function are linked or set, and no thread runs it, nor another function \
                that would do the same.",
        matters: "Its outputs never change, its inputs are never looked at.",
        remedy: "Add it to a thread: addf FUNCT THREAD.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt or2 # <--\nloadrt not\n\
                addf not.0 servo\nnet any or2.0.out => not.0.in\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\nloadrt not\n\
                addf or2.0 servo\naddf not.0 servo\nnet any or2.0.out => not.0.in\nnet none not.0.out\nstart\n",
    },
    Explanation {
        code: Code::AddedTwice,
        means: "The function is in a thread already, and is not made for being in two.",
        matters: "halrun stops at this line.",
        remedy: "Take one of the two lines out.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\n\
                addf or2.0 servo # <--\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\nstart\n",
    },
    Explanation {
        code: Code::BadPosition,
        means: "Positions count from 1, or from -1 backwards, and the thread has not so many \
                functions.",
        matters: "halrun stops at this line.",
        remedy: "Without a number the function is added as the last.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo 2 # <--\n\
                start\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo 1\nstart\n",
    },
    Explanation {
        code: Code::EmptyThread,
        means: "No function was added to the thread.",
        matters: "It costs processor time for nothing. Often the functions went to another thread.",
        remedy: "Add functions to it, or make no such thread.",
        wrong: "loadrt threads name1=base period1=100000 name2=servo period2=1000000 # <--\n\
                loadrt or2\naddf or2.0 servo\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\nstart\n",
    },
    Explanation {
        code: Code::NeverStarted,
        means: "Threads have functions, and no line starts them.",
        matters: "Nothing moves until someone says 'halcmd start'. It is a warning where a line \
                  loads threads itself.",
        remedy: "End the script with start. An INI start does it by itself.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\nstart\n",
    },
    Explanation {
        code: Code::FastInSlow,
        means: "The function makes pulses, watches edges or passes pulses on, which belongs in the \
                fastest thread, and it is in a slower one.",
        matters: "Steps come with the slow period: far fewer of them, and edges are missed.",
        remedy: "Add it to the fastest thread.",
        wrong: "loadrt threads name1=base period1=100000 name2=servo period2=1000000\n\
                loadrt stepgen step_type=0\naddf stepgen.make-pulses servo # <--\n\
                addf stepgen.update-freq servo\nstart\n",
        right: "loadrt threads name1=base period1=100000 name2=servo period2=1000000\n\
                loadrt stepgen step_type=0\naddf stepgen.make-pulses base\n\
                addf stepgen.update-freq servo\nstart\n",
    },
    Explanation {
        code: Code::SlowInFast,
        means: "The function computes with numbers, its component has another one for the fast \
                thread, and it is in the fast thread as well.",
        matters: "It takes time in every fast period, and for nothing: what it computes is needed \
                  once in a slow one.",
        remedy: "Add it to the slow thread.",
        wrong: "loadrt threads name1=base period1=100000 name2=servo period2=1000000\n\
                loadrt stepgen step_type=0\naddf stepgen.make-pulses base\n\
                addf stepgen.update-freq base # <--\nstart\n",
        right: "loadrt threads name1=base period1=100000 name2=servo period2=1000000\n\
                loadrt stepgen step_type=0\naddf stepgen.make-pulses base\n\
                addf stepgen.update-freq servo\nstart\n",
    },
    Explanation {
        code: Code::OrderCosts,
        means: "Functions of a thread run in the order of their addf lines, and this one runs \
                before one whose output it reads.",
        matters: "It has the value of the cycle before: one period more of delay on that way.",
        remedy: "Add them in the order that is given. 'halcmd order' shows all of it.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt or2\nloadrt not\n\
                addf not.0 servo # <--\naddf or2.0 servo\nnet any or2.0.out => not.0.in\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\nloadrt not\n\
                addf or2.0 servo\naddf not.0 servo\nnet any or2.0.out => not.0.in\n\
                net none not.0.out\nstart\n",
    },
    Explanation {
        code: Code::Feedback,
        means: "Values go from function to function and come back to the first.",
        matters: "Every control loop is one; its delay limits the gains. One that is not meant \
                  latches or rings.",
        remedy: "Nothing, if it is meant.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt or2\nloadrt not\n\
                addf or2.0 servo # <--\naddf not.0 servo\nnet any or2.0.out => not.0.in\n\
                net none not.0.out => or2.0.in0\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\nloadrt not\n\
                addf or2.0 servo\naddf not.0 servo\nnet any or2.0.out => not.0.in\nnet none not.0.out\nstart\n",
    },
    Explanation {
        code: Code::Crossing,
        means: "A function of one thread writes the signal, and one of another thread reads it.",
        matters: "The reader may see it a period later, and two signals that belong together in \
                  different states.",
        remedy: "Nothing, if the delay does no harm.",
        wrong: "loadrt threads name1=base period1=100000 name2=servo period2=1000000\nloadrt or2\n\
                loadrt not\naddf not.0 base\naddf or2.0 servo\n\
                net any or2.0.out => not.0.in # <--\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\nloadrt not\n\
                addf or2.0 servo\naddf not.0 servo\nnet any or2.0.out => not.0.in\nnet none not.0.out\nstart\n",
    },
    Explanation {
        code: Code::BadPeriod,
        means: "A thread's period is out of range, or shorter than that of a thread that exists: \
                the fastest is made first.",
        matters: "halrun stops at this line.",
        remedy: "Make the fastest thread first; periods are in nanoseconds.",
        wrong: "loadrt threads name1=servo period1=1000000 name2=base period2=100000 # <--\n",
        right: "loadrt threads name1=base period1=100000 name2=servo period2=1000000\n",
    },
    Explanation {
        code: Code::NothingHandedOver,
        means: "A function works on what another function of its component hands to it, and no \
                thread runs that other one.",
        matters: "It works on nothing: without motion-command-handler, no command reaches motion.",
        remedy: "Add the other function to the same thread, before it.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt stepgen step_type=0 # <--\n\
                addf stepgen.update-freq servo\nstart\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt stepgen step_type=0\n\
                addf stepgen.make-pulses servo\naddf stepgen.update-freq servo\nstart\n",
    },
    Explanation {
        code: Code::NeedsFp,
        means: "The function computes with floating-point numbers, and its thread was made for functions \
                that do not: with fp1=0, or as motmod's base thread without base_thread_fp=1.",
        matters: "LinuxCNC refuses it as well: on old systems such a thread did not save the registers of \
                  the processor for these numbers.",
        remedy: "Add it to another thread, or create the thread with floating point.",
        wrong: "loadrt threads name1=base period1=100000 fp1=0 name2=servo period2=1000000\n\
                loadrt limit1\naddf limit1.0 base # <--\nstart\n",
        right: "loadrt threads name1=base period1=100000 fp1=0 name2=servo period2=1000000\n\
                loadrt limit1\naddf limit1.0 servo\nstart\n",
    },
    Explanation {
        code: Code::OrderLate,
        means: "A function that moves a motor, or tells where it is, runs before the one whose result it \
                works on.",
        matters: "The motor follows its command a cycle later: following errors grow, and control loops \
                  may oscillate.",
        remedy: "Add them in the order of the values: positions are read, motion computes, motors are \
                 commanded.",
        wrong: "loadrt iocontrol interlock=1\nloadrt trivkins\n\
                loadrt motmod base_period_nsec=100000 servo_period_nsec=1000000 num_joints=1\n\
                loadrt stepgen step_type=0\naddf stepgen.make-pulses base-thread\n\
                addf stepgen.capture-position servo-thread\naddf stepgen.update-freq servo-thread # <--\n\
                addf motion-command-handler servo-thread\naddf motion-controller servo-thread\n\
                net x-cmd joint.0.motor-pos-cmd => stepgen.0.position-cmd\n\
                net x-fb stepgen.0.position-fb => joint.0.motor-pos-fb\n\
                net x-on joint.0.amp-enable-out => stepgen.0.enable\n\
                net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\nstart\n",
        right: "loadrt iocontrol interlock=1\nloadrt trivkins\n\
                loadrt motmod base_period_nsec=100000 servo_period_nsec=1000000 num_joints=1\n\
                loadrt stepgen step_type=0\naddf stepgen.make-pulses base-thread\n\
                addf stepgen.capture-position servo-thread\naddf motion-command-handler servo-thread\n\
                addf motion-controller servo-thread\naddf stepgen.update-freq servo-thread\n\
                net x-cmd joint.0.motor-pos-cmd => stepgen.0.position-cmd\n\
                net x-fb stepgen.0.position-fb => joint.0.motor-pos-fb\n\
                net x-on joint.0.amp-enable-out => stepgen.0.enable\n\
                net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\nstart\n",
    },
];
