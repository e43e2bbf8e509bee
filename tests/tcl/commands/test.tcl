# What the commands of HAL return to Tcl, and the errors that they raise.
proc try_it {args} {
    set failed [catch {uplevel #0 $args} text]
    puts "$args => [expr {$failed ? "error " : ""}]<$text>"
}
try_it hal loadrt threads name1=servo period1=1000000
try_it hal loadrt and2 count=2
try_it hal addf and2.0 servo
try_it hal net a and2.0.out => and2.1.in0
try_it hal getp and2.0.in0
try_it hal setp and2.0.in0 1
try_it hal getp and2.0.in0
try_it hal setp and2.0.nope 1
try_it hal getp and2.0.nope
try_it hal setp and2.0.in0 banana
try_it hal gets a
try_it hal gets nosig
try_it hal sets a 1
try_it hal newsig x float
try_it hal newsig x float
try_it hal newsig q nonsense
try_it hal sets x 2.5
try_it hal gets x
try_it hal stype x
try_it hal ptype and2.0.in0
try_it hal unlinkp and2.1.in0
try_it hal unlinkp and2.9.in0
try_it hal linksp a and2.1.in0
try_it hal linkps and2.1.in1 a
try_it hal list pin and2.0*
try_it hal list pin nothing*
try_it hal list sig
try_it hal list nonsense
try_it hal show pin and2.0.i*
try_it hal show pin zz
try_it hal show sig
try_it hal nosuchcmd
try_it hal
try_it hal delsig x
try_it hal delsig x
try_it hal save netl
try_it hal alias pin and2.0.in0 nicer
try_it hal unalias pin nicer
try_it hal start
try_it hal run 3ms
try_it hal stop
try_it hal lock all
try_it hal newsig zz bit
try_it hal unlock all
try_it hal delf and2.0 servo
try_it hal delf and2.0 servo
try_it hal unloadrt and2
try_it hal net
try_it hal setp
try_it hal loadusr -w true
try_it hal loadusr -w false
try_it hal waitusr nobody
# The plain commands. Their names are Tcl's own where it has such a command.
loadrt or2 names=first,second
try_it setp first.in0 2-1
try_it getp first.in0
try_it newsig s float
try_it sets s "6.28 / 2"
try_it hal gets s
try_it setp first.in0 yes+no
try_it list sig
show pin second*
puts [lsort [lmap name {addf alias delf delsig getp gets net setp show source waitusr} {
    expr {$name in [hal --commands] ? $name : "no $name"}
}]]
# A text with letters of every kind, and one with a line in it.
try_it hal newsig "a b" bit
try_it hal getp "grün\nzwei"
puts [list $argv $argc [file tail $argv0] [file tail [info script]]]
