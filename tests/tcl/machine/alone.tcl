puts "joints $::KINS(JOINTS) [info exists ::env(CONFIG_DIR)]"
parse_ini more.inc
puts $::EXTRA(WORD)
