loadrt and2
set x [expr {1 / 0}]
