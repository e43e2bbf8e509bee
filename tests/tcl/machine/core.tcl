puts "argv $argv, [file tail $argv0], [file exists $::env(HALLIB_DIR)/procs.tcl] [file tail $::env(INI_FILE_NAME)]"
puts "words $::EXTRA(WORD), second [lindex $::EXTRA(WORD) 1], scale $::JOINT_0(SCALE)"
loadrt trivkins coordinates=XY
loadrt motmod servo_period_nsec=$::EMCMOT(SERVO_PERIOD) num_joints=$::KINS(JOINTS)
puts "halui [hal list comp halui]"
addf motion-command-handler servo-thread
addf motion-controller servo-thread
for {set j 0} {$j < $::KINS(JOINTS)} {incr j} {
    net pos$j joint.$j.motor-pos-cmd => joint.$j.motor-pos-fb
}
net estop-loop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in
