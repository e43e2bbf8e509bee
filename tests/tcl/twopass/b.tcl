puts "pass [::tp::passnumber]: <[getp a1.in0]> <[hal list comp and2]>"
loadrt and2 names=b1,b2
loadrt or2 count=1
loadrt logic names=l1 personality=0x102
loadrt $::GATE(LOAD)
foreach name {b1 b2 l1 l2} { addf $name servo }
setp a1.in0 1
setp a1.in1 1
