source [file join $::env(HALLIB_DIR) procs.tcl]
switches $::KINS(JOINTS)
