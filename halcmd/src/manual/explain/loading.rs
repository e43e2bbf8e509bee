//! Explanations of findings about components and names.

use super::explanation::Explanation;
use hal_protocol::Code;

pub(super) const ROWS: &[Explanation] = &[
    Explanation {
        code: Code::NoComponent,
        means: "No plugin library on the path offers a component of this name, or the library \
                cannot be used.",
        matters: "halrun stops at this line; nothing that the component would have made exists.",
        remedy: "Correct the name, or name the folder of the plugin in HAL_RTMOD_DIR.",
        wrong: "loadrt and3 # <--\n",
        right: "loadrt and2\n",
    },
    Explanation {
        code: Code::NoSuchName,
        means: "There is no pin, parameter, signal, function, thread or component of this name at \
                this line.",
        matters: "halrun stops at this line.",
        remedy: "The nearest name is proposed. Names exist only after their loadrt or newsig line; \
                 'halcmd show' lists those of a machine that runs.",
        wrong: "loadrt or2\nsetp or2.0.in9 1 # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\n\
                setp or2.0.in0 1\nstart\n",
    },
    Explanation {
        code: Code::NameTaken,
        means: "Something has this name already: a component is loaded once, with count= or \
                names= for more than one, and a signal is made once.",
        matters: "halrun stops at this line.",
        remedy: "Load all of a component in one line, or choose another name.",
        wrong: "loadrt or2\nloadrt or2 # <--\n",
        right: "loadrt or2 count=2\n",
    },
    Explanation {
        code: Code::BadName,
        means: "The name is too long, empty, or has blanks in it.",
        matters: "halrun stops at this line.",
        remedy: "Choose a shorter one of letters, digits, '-', '_' and '.'.",
        wrong: "newsig the-signal-of-the-switch-at-the-end-of-the-axis-that-goes-to-the-left-of-the-\
                door-of-the-machine-in-the-corner-of-the-hall bit # <--\n",
        right: "newsig min-x bit\n",
    },
    Explanation {
        code: Code::BadArgument,
        means: "The component has no such argument, or not with this value.",
        matters: "halrun stops at this line.",
        remedy: "The nearest argument is proposed; components/README.md says where each component \
                 explains its own.",
        wrong: "loadrt or2 cout=2 # <--\n",
        right: "loadrt or2 count=2\n",
    },
    Explanation {
        code: Code::LoadRefused,
        means: "The component was found and its arguments read, and it refuses for the reason \
                that it gives.",
        matters: "halrun stops at this line.",
        remedy: "The sentence says what is wrong.",
        wrong: "loadrt stepgen step_type=0 ctrl_type=x # <--\n",
        right: "loadrt stepgen step_type=0 ctrl_type=v\n",
    },
    Explanation {
        code: Code::NoService,
        means: "The component uses what another one offers, such as kinematics, and that one is \
                not loaded yet.",
        matters: "halrun stops at this line.",
        remedy: "Load the other one first.",
        wrong: "loadrt motmod servo_period_nsec=1000000 num_joints=1 # <--\n",
        right: "loadrt iocontrol interlock=1\nloadrt trivkins\n\
                loadrt motmod servo_period_nsec=1000000 num_joints=1\n\
                addf motion-command-handler servo-thread\naddf motion-controller servo-thread\n\
                net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\nstart\n",
    },
    Explanation {
        code: Code::BadCall,
        means: "The component's command has no argument of this name.",
        matters: "halrun stops at this line.",
        remedy: "'halcmd show' of a machine that runs, and 'halcmd commands', list the arguments.",
        wrong: "loadrt trivkins\nloadrt motmod servo_period_nsec=1000000 num_joints=1\n\
                motion.jog jont=0 velocity=5 # <--\n",
        right: "loadrt iocontrol interlock=1\nloadrt trivkins\n\
                loadrt motmod servo_period_nsec=1000000 num_joints=1\n\
                addf motion-command-handler servo-thread\naddf motion-controller servo-thread\n\
                net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\n\
                motion.jog joint=0 velocity=5\n",
    },
    Explanation {
        code: Code::AliasShadows,
        means: "A pin was given the name that a parameter has, or a parameter that of a pin.",
        matters: "setp and getp take the pin: the parameter can no longer be reached by its name.",
        remedy: "Choose a name that nothing has.",
        wrong: "loadrt or2\nloadrt stepgen step_type=0\n\
                alias pin or2.0.out stepgen.0.maxvel # <--\n",
        right: "loadrt or2\nloadrt stepgen step_type=0\nalias pin or2.0.out any-limit\n",
    },
    Explanation {
        code: Code::Unused,
        means: "No pin of the component is linked, nothing of it is set, and no thread runs its \
                functions.",
        matters: "It does nothing. Often its functions were forgotten.",
        remedy: "Link its pins and add its functions, or do not load it.",
        wrong: "loadrt or2 # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\nstart\n",
    },
    Explanation {
        code: Code::Foreign,
        means: "The component is written in C (or is LinuxCNC's own): its functions are code that \
                Ferrule runs and does not see into.",
        matters: "Findings about order, loops and delays are silent about its functions, and \
                  'halcmd order' leaves them where they are. What is said of its pins holds.",
        remedy: "Put its functions between those that feed its inputs and those that read its \
                 outputs. Where Ferrule has a component of its own, use that.",
        wrong: "loadrt threads name1=servo period1=1000000\nloadrt turner # <--\n\
                addf turner.0 servo\nstart\n\
                --- turner.comp\ncomponent turner;\npin out bit out;\nfunction _;\n\
                license \"MIT\";\n;;\nout = !out;\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt charge_pump\n\
                addf charge-pump servo\nstart\n",
    },
    Explanation {
        code: Code::LoadedAlready,
        means: "A HAL file loads iocontrol (or io, or iov2), which a start from an INI file has \
                loaded before the HAL files, or halui, which it loads itself; or the file starts \
                milltask or linuxcncsvr, whose work is built in.",
        matters: "The line does nothing, and its arguments count for nothing: the machine keeps \
                  the iocontrol whose e-stop switches motion off.",
        remedy: "Take the line out, or leave it for starts without an INI file.",
        wrong: "loadrt iocontrol cycle_time=0.05 # <--\n\
                net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\n\
                --- m.ini\n[EMCIO]\nCYCLE_TIME = 0.1\n[HAL]\nHALFILE = m.hal\n",
        right: "net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\n\
                --- m.ini\n[EMCIO]\nCYCLE_TIME = 0.1\n[HAL]\nHALFILE = m.hal\n",
    },
];
