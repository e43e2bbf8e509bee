//! Explanations of findings about step pulses.

use super::explanation::Explanation;
use hal_protocol::Code;

/// A script with a step generator and a driver, each in a thread of its own. `$more` is appended.
macro_rules! steps {
    ($load:literal, $base:literal, $more:literal) => {
        concat!(
            "loadrt threads name1=base period1=100000 name2=servo period2=1000000\n",
            "loadrt stepgen step_type=0\n",
            $load,
            "addf stepgen.make-pulses base\n",
            $base,
            "addf stepgen.capture-position servo\naddf stepgen.update-freq servo\n",
            "setp stepgen.0.position-cmd 0\n",
            $more,
            "start\n"
        )
    };
}

pub(super) const ROWS: &[Explanation] = &[
    Explanation {
        code: Code::StepsTooFast,
        means: "maxvel times position-scale is more steps in a second than pulses of this length \
                and gap can be made in the thread's period.",
        matters: "The motor stays behind its command: a following error, or lost steps.",
        remedy: "A lower maxvel, a shorter base period, less microstepping, or with a port that \
                 resets its pins, stepspace 0.",
        wrong: steps!(
            "",
            "",
            "setp stepgen.0.position-scale 400\nsetp stepgen.0.maxvel 20 # <--\n"
        ),
        right: steps!("", "", "setp stepgen.0.position-scale 400\nsetp stepgen.0.maxvel 10\n"),
    },
    Explanation {
        code: Code::DoubleStep,
        means: "stepspace 0 lets a step come in every period, and the port does not end the pulses \
                by itself.",
        matters: "Two steps in neighbouring periods are one long pulse: the motor makes one step. \
                  It works as long as no axis is that fast.",
        remedy: "Let stepspace be 1 or more; or, with a port that has a reset function, run that \
                 after the write and set -out-reset on the step pins.",
        wrong: steps!(
            "loadrt hal_viagpio\n",
            "addf viagpio.write base\n",
            "setp stepgen.0.stepspace 0 # <--\nnet xstep stepgen.0.step => viagpio.pin-06-out\n"
        ),
        right: steps!(
            "loadrt hal_viagpio\n",
            "addf viagpio.write base\n",
            "setp stepgen.0.stepspace 1\nnet xstep stepgen.0.step => viagpio.pin-06-out\n\
             net xdir stepgen.0.dir => viagpio.pin-05-out\n"
        ),
    },
    Explanation {
        code: Code::StepsMerge,
        means: "As H602, and the speed that is asked for does need a step in every period.",
        matters: "Above that speed pulses merge, and steps are lost without a word.",
        remedy: "Let stepspace be 1 or more and the speed lower; or, with a port that has a reset \
                 function, run that after the write and set -out-reset on the step pins.",
        wrong: steps!(
            "loadrt hal_viagpio\n",
            "addf viagpio.write base\n",
            "setp stepgen.0.stepspace 0 # <--\nsetp stepgen.0.position-scale 400\n\
             setp stepgen.0.maxvel 20\nnet xstep stepgen.0.step => viagpio.pin-06-out\n"
        ),
        right: steps!(
            "loadrt hal_viagpio\n",
            "addf viagpio.write base\n",
            "setp stepgen.0.stepspace 1\nsetp stepgen.0.position-scale 400\n\
             setp stepgen.0.maxvel 10\nnet xstep stepgen.0.step => viagpio.pin-06-out\n\
             net xdir stepgen.0.dir => viagpio.pin-05-out\n"
        ),
    },
    Explanation {
        code: Code::ResetUnmarked,
        means: "stepspace 0 lets a step come in every period, the port's reset function runs, and \
                the step pin is not among those that it resets.",
        matters: "Two steps in neighbouring periods are one long pulse: the motor makes one step.",
        remedy: "setp parport.N.pin-NN-out-reset 1 for each step pin.",
        wrong: steps!(
            "loadrt hal_parport cfg=0x378\n",
            "addf parport.0.write base\naddf parport.0.reset base\n",
            "setp stepgen.0.stepspace 0\nsetp parport.0.reset-time 5000\n\
             net xstep stepgen.0.step => parport.0.pin-03-out # <--\n"
        ),
        right: steps!(
            "loadrt hal_parport cfg=0x378\n",
            "addf parport.0.write base\naddf parport.0.reset base\n",
            "setp stepgen.0.stepspace 0\nsetp parport.0.reset-time 5000\n\
             setp parport.0.pin-03-out-reset 1\n\
             net xstep stepgen.0.step => parport.0.pin-03-out\n\
             net xdir stepgen.0.dir => parport.0.pin-04-out\n"
        ),
    },
    Explanation {
        code: Code::ResetNotRun,
        means: "A pin is to be reset, and no thread runs the port's reset function.",
        matters: "The pulses are not ended: the setting has no effect.",
        remedy: "addf parport.N.reset to the fast thread, after parport.N.write.",
        wrong: steps!(
            "loadrt hal_parport cfg=0x378\n",
            "addf parport.0.write base\n",
            "setp parport.0.pin-03-out-reset 1 # <--\n\
             net xstep stepgen.0.step => parport.0.pin-03-out\n"
        ),
        right: steps!(
            "loadrt hal_parport cfg=0x378\n",
            "addf parport.0.write base\naddf parport.0.reset base\n",
            "setp parport.0.pin-03-out-reset 1\n\
             net xstep stepgen.0.step => parport.0.pin-03-out\n\
             net xdir stepgen.0.dir => parport.0.pin-04-out\n"
        ),
    },
    Explanation {
        code: Code::ResetLate,
        means: "reset-time is more than a quarter of the thread's period, which is as long as the \
                reset function waits.",
        matters: "It waits a quarter of the period: pulses are shorter than was asked for.",
        remedy: "Set less, or make the period longer.",
        wrong: steps!(
            "loadrt hal_parport cfg=0x378\n",
            "addf parport.0.write base\naddf parport.0.reset base\n",
            "setp parport.0.reset-time 50000 # <--\nsetp parport.0.pin-03-out-reset 1\n\
             net xstep stepgen.0.step => parport.0.pin-03-out\n"
        ),
        right: steps!(
            "loadrt hal_parport cfg=0x378\n",
            "addf parport.0.write base\naddf parport.0.reset base\n",
            "setp parport.0.reset-time 5000\nsetp parport.0.pin-03-out-reset 1\n\
             net xstep stepgen.0.step => parport.0.pin-03-out\n\
             net xdir stepgen.0.dir => parport.0.pin-04-out\n"
        ),
    },
];
