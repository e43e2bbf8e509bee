(grbl laser engraving)
$H
$X
$32=1
G21 G90
G0 X5 Y5
M4 S700
G1 X40 F900 S300
?
!
~
$J=G91 X-5 F500
M5
M2
