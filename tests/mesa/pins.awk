# Takes what halrun shows, and prints a line for each I/O pin, HAL pin, parameter and function.
#
#   io NUMBER TERMINAL USE
#   pin NAME TYPE DIRECTION VALUE
#   param NAME TYPE DIRECTION VALUE
#   funct NAME USES-FLOATING-POINT
/IO Pin [0-9]+ \(/ {
  line = $0
  sub(/^.*IO Pin /, "", line)
  sub(/ \(/, " ", line)
  sub(/\): /, " ", line)
  print "io " line
}
/^Component Pins:/ { kind = "pin" }
/^Parameters:/ { kind = "param" }
/^Exported Functions:/ { kind = "funct" }
kind == "pin" && $5 ~ /^hm2_/ { print kind, $5, $2, $3, $4 }
kind == "param" && $5 ~ /^hm2_/ { print kind, $5, $2, $3, $4 }
kind == "funct" && $NF ~ /^hm2_/ { print kind, $NF, $4 }
