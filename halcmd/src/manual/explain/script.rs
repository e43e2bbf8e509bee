//! Explanations of findings about lines of scripts, and about the programs that they start.

use super::explanation::Explanation;
use hal_protocol::Code;

pub(super) const ROWS: &[Explanation] = &[
    Explanation {
        code: Code::Unreadable,
        means: "The line cannot be split into words: a quotation has no end, a bracket is not \
                closed, a variable has no name, or the line is too long.",
        matters: "halrun stops at this line.",
        remedy: "Close the quotation or the bracket. $NAME and $(NAME) are environment variables, \
                 [SECTION]NAME and [SECTION](NAME) are INI entries.",
        wrong: "print \"ready # <--\n",
        right: "print \"ready\"\n",
    },
    Explanation {
        code: Code::UnknownCommand,
        means: "The first word is neither a command nor a command of a component that is loaded.",
        matters: "halrun stops at this line.",
        remedy: "'halcmd help' lists the commands, 'halcmd commands' those of components.",
        wrong: "loadtr and2 # <--\n",
        right: "loadrt and2\n",
    },
    Explanation {
        code: Code::WrongWords,
        means: "The command exists, but has too many or too few words, or one that it does not \
                know.",
        matters: "halrun stops at this line.",
        remedy: "'halcmd help COMMAND' shows its words.",
        wrong: "loadrt and2\nsetp and2.0.in0 # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt and2\naddf and2.0 servo\n\
                setp and2.0.in0 1\nstart\n",
    },
    Explanation {
        code: Code::NoEnvironment,
        means: "The line uses $NAME, and the environment has no such variable.",
        matters: "halrun stops at this line; on another computer it may not.",
        remedy: "Write the value, take it from the INI file, or export the variable before.",
        wrong: "loadrt threads name1=servo period1=$NO_SUCH_PERIOD # <--\n",
        right: "loadrt threads name1=servo period1=1000000\n",
    },
    Explanation {
        code: Code::NoIniEntry,
        means: "The line uses [SECTION]NAME, and the INI file has no such entry, or no INI file \
                was given.",
        matters: "halrun stops at this line.",
        remedy: "Add the entry, correct the name (letters count), or give the INI file: halcmd \
                 check -i machine.ini FILE.",
        wrong: "loadrt threads name1=servo period1=[EMCMOT]SERVO_PERIODE # <--\n\
                --- m.ini\n[EMCMOT]\nSERVO_PERIOD = 1000000\n",
        right: "loadrt threads name1=servo period1=[EMCMOT]SERVO_PERIOD\n\
                --- m.ini\n[EMCMOT]\nSERVO_PERIOD = 1000000\n",
    },
    Explanation {
        code: Code::NoFile,
        means: "The file cannot be opened.",
        matters: "halrun stops at this line.",
        remedy: "Correct the name. With an INI file, relative names are beside it; otherwise they \
                 are in the folder where halrun is started.",
        wrong: "source wiring.hal # <--\n",
        right: "source more.hal\n--- more.hal\nprint \"wiring\"\n",
    },
    Explanation {
        code: Code::Refused,
        means: "The line is refused for the reason that it gives.",
        matters: "halrun stops at this line.",
        remedy: "The sentence says what is wrong.",
        wrong: "lock all\nnewsig x bit # <--\n",
        right: "newsig x bit\nlock all\n",
    },
    Explanation {
        code: Code::DosLines,
        means: "Lines end in a carriage return and a line feed.",
        matters: "It works here; other programs may take the carriage return for a part of the \
                  last word.",
        remedy: "Save the file with lines that end in a line feed alone.",
        wrong: "print ready # <--\r\n",
        right: "print ready\n",
    },
    Explanation {
        code: Code::ProgramPins,
        means: "A program makes these pins when it is started, and a check starts nothing.",
        matters: "A wrong name among them, a wrong type or a second writer is not found.",
        remedy: "Start the machine, simulated if need be, and check what runs: halcmd check.",
        wrong: "loadrt or2\nloadusr -Wn panel python3 panel.py # <--\n\
                net light panel.light => or2.0.in0\n",
        right: "loadusr -W hal_manualtoolchange\nnewsig done bit\n\
                net done hal_manualtoolchange.changed\n",
    },
    Explanation {
        code: Code::NoProgramAwaited,
        means: "The program is neither beside halrun nor in PATH, and the line waits for it.",
        matters: "halrun stops at this line.",
        remedy: "Install it, correct its name, or give its path.",
        wrong: "loadusr -W hal_manualtoolchang # <--\n",
        right: "loadusr -W hal_manualtoolchange\n",
    },
    Explanation {
        code: Code::NoProgram,
        means: "The program is neither beside halrun nor in PATH. Nothing waits for it.",
        matters: "The machine starts without it.",
        remedy: "Install it, correct its name, or give its path.",
        wrong: "loadusr halsamplr -n 10 # <--\n",
        right: "loadusr halsampler -n 10\n",
    },
    Explanation {
        code: Code::NotSupported,
        means: "Ferrule does not do this: another module for the trajectory planner.",
        matters: "halrun refuses the machine.",
        remedy: "Take TPMOD out: the trajectory planner is part of motmod.",
        wrong: "print ready\n--- m.ini\n[EMCIO]\nCYCLE_TIME = 0.1\n[TRAJ]\nTPMOD = mine\n# <--\n\
                [HAL]\nHALFILE = m.hal\n",
        right: "net estop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\n\
                --- m.ini\n[EMCIO]\nCYCLE_TIME = 0.1\n[HAL]\nHALFILE = m.hal\n",
    },
    Explanation {
        code: Code::IdleAllowance,
        means: "A comment allows a finding that is not there: it was put right, has another code, \
                or stands on another line.",
        matters: "It would hide that finding if it came back.",
        remedy: "Take the comment out, or move it: it stands at the end of the line that it is \
                 about, or above it.",
        wrong: "loadrt or2\nsetp or2.0.in0 1 # check: allow H403 tried by hand # <--\n",
        right: "loadrt threads name1=servo period1=1000000\nloadrt or2\naddf or2.0 servo\n\
                setp or2.0.in0 1\nstart\n",
    },
    Explanation {
        code: Code::TclNotFollowed,
        means: "The Tcl file asks for something outside, such as another program or the value of a pin that \
                only the machine knows; or tclsh is not installed. What comes before is checked, the rest of \
                the file is not.",
        matters: "The check accepts every name from there on.",
        remedy: "Check the running machine: halcmd check. If the line may fail, a catch around it lets the \
                 check go on behind it.",
        wrong: "--- m.ini\n[EMCIO]\n[HAL]\nHALFILE = m.tcl\n--- m.tcl\nset host [exec hostname] ;# <--\n",
        right: "--- m.ini\n[EMCIO]\n[HAL]\nHALFILE = m.tcl\n--- m.tcl\nset host [info hostname]\nnet estop-loop iocontrol.0.user-enable-out iocontrol.0.emc-enable-in\n",
    },
];
