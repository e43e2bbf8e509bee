source part.tcl
foreach name {a b} { addf $name servo }
net x a.out => b.in0
net y b.out => a.in0
setp a.in1 1
setp b.in1 [expr {[getp a.in1] ? 1 : 0}]
puts "not shown"
hal save all kept
set file [open kept]
set lines [split [read $file] \n]
close $file
if {"loadrt and2 names=a,b" ni [lmap line $lines {string trim $line}]} { error $lines }
set file [open made w]
puts $file "text"
close $file
if {![file exists made] || [file exists never]} { error "files" }
# Nothing is changed outside, whichever word would do it.
set before [file mtime part.tcl]
file mtime part.tcl 0
file mkd folder
file delete part.tcl
if {![file exi part.tcl] || [file exists folder] || [file mtime part.tcl] != $before} { error "changed" }
start
