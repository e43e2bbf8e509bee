source part.tcl
addf a servo

setp a.in7 1
