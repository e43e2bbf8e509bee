source not-there.tcl
