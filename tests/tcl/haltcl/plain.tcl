package require Hal
package require Linuxcnc
puts [hal getp and2.0.in0]
puts [info commands getp]
parse_ini m.ini
puts $::MACHINE(NAME)
