puts "joints $::KINS(JOINTS) [info exists ::env(CONFIG_DIR)]"
parse_ini other.ini
puts $::OTHER(WORD)
