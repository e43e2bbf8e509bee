puts "$argv0 <[lindex $argv 1]> $::MACHINE(NAME)"
setp and2.0.in0 1
puts [getp and2.0.in0]
