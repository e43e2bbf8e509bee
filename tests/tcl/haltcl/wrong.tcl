puts [getp and2.0.in0]
proc deep {} { hal loadrt nosuch }
deep
