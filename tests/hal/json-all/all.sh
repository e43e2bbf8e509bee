# Both streams, told apart. Addresses and processes differ from run to run.
say() {
    echo "> $*"
    halcmd --json "$@" 2>err | sed 's/"code":[0-9]*,"arg":[0-9]*/"code":1,"arg":2/; s/"pid":[0-9]*/"pid":3/; s/"memory":\[[0-9]*/"memory":[4/; s/halcmd[0-9]*/halcmd9/g'
    sed 's/^/! /' err
}
say getp not.0.out
say ptype not.0.out
say gets x
say stype x
say show comp
say show pin not.0
say show sig
say show param not.0.tmax
say show funct
say show thread
say show alias
say list pin not
say save
say status lock
say commands
say print hello
say echo
say unecho
say help unlinkp
say help nonsense
say completion klingon
say watch --count 1 door x
say setexact_for_test_suite_only
say -v start
say setp nothing 5
say setp not.0.out 5
say net x not.0.otu
say loadrt nothing
say nonsense
say getp
say -f missing.hal
say -h unlock
say status nonsense
printf 'print "in a file"\ngetp dor\n  setp door 5x\n' > wrong.hal
say -kf wrong.hal
say --instance nobody start
rm err wrong.hal
