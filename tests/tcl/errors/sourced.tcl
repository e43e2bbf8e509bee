source [file join [file dirname [info script]] part.tcl]
