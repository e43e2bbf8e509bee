loadrt and2 names=b
setp c.in0 1
