puts "no kinematics"
exit 3
