package require Hal
proc switches {count} {
    set names {}
    for {set j 0} {$j < $count} {incr j} { lappend names switch$j }
    loadrt sim_home_switch names=[join $names ,]
    foreach name $names j {0 1} {
        addf $name servo-thread
        net pos$j => $name.cur-pos
        setp $name.home-pos [lindex $::JOINT_0(MAX_VELOCITY) 0]*$j/4.0
    }
}
