source part.tcl
addf a servo
addf b servo
catch {exec hostname}
setp a.in0 1
