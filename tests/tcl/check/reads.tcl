source part.tcl
puts [open not-there]
