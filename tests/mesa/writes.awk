# Takes hm2card's record, and prints what a driver reads and writes.
#
#   start                     reads and writes before the first cycle, without the firmware's account of itself; of
#                             smart serial only commands to the port and what is asked of remotes
#   cycle N                   what is read (if other registers than before), the order of writes (if other), and each
#                             value that is not as in the cycle before
#
# The counters by which a driver confirms its packets stand in the order, without their values.
function flush_cycle(  n, i, name) {
  if (cycle < 1) return
  print "cycle " cycle
  if (reads != old_reads) print "  reads" reads
  if (order != old_order) print "  order" order
  old_reads = reads; old_order = order
  n = split(order, names, " ")
  for (i = 1; i <= n; i++) {
    name = names[i]
    if (name in value && (value[name] "") != (old[name] "")) {
      print "  " name " = " value[name]
      old[name] = value[name]
    }
  }
  split("", value); reads = ""; order = ""
}
/^packet/ {
  if ($3 == "cycle") {
    if (cycles != "" && cycles + 0 < $4 + 0) exit
    flush_cycle()
    cycle = $4
  }
  next
}
$1 == "read" {
  name = $3 == "-" ? $2 : $3
  if ($2 ~ /:/) name = $2
  if (cycle < 1) {
    if ($3 != "-" && $3 !~ /^SERIAL_/) print "start read " substr($0, index($0, $2))
  } else reads = reads " " name "/" $NF
  next
}
$1 == "write" {
  name = $3 == "-" || $2 ~ /:/ ? $2 : $3
  if (cycle < 1) {
    if (!(name ~ /^SERIAL_COMMAND/ && $NF ~ /^000010/)) print "start write " name " = " $NF
  }
  else {
    order = order " " name
    if ($2 !~ /^4:/) value[name] = $NF
  }
}
END { flush_cycle() }
