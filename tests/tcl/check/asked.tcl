source part.tcl
addf a servo
loadusr panel.py
if {[getp panel.mode] == 3} { addf b servo }
