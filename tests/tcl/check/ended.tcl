source part.tcl
puts "no kinematics"
exit 1
