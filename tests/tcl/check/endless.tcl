source part.tcl
while 1 {}
