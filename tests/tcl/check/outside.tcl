source part.tcl
addf a servo
set host [exec hostname]
setp nothing.of.that 1
