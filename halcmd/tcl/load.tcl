# Scripts of LinuxCNC load its library `hal.so` by its path when `hal` is first called. The command of this package takes its
# place.

namespace eval ::ferrule {
    # Folder of the package.
    variable here [file dirname [file normalize [info script]]]
    # Number of procedures of other scripts that loaded the library. A scan of packages reads this file again.
    variable loaders
    if {![info exists loaders]} { set loaders 0 }
}

# Makes `hal` this package's command again, whatever a script has made of it.
proc ::ferrule::keep_hal {} {
    variable here
    variable loaders
    # The procedure that runs now stays, under another name: `info frame` reads the commands of all levels.
    if {[info commands ::hal] ne {}} { rename ::hal ::ferrule::loader[incr loaders] }
    if {[info commands ::ferrule::hal] eq {}} { uplevel #0 [list source [file join $here hal.tcl]] }
    proc ::hal args { tailcall ::ferrule::hal {*}$args }
}

# Has `load` take this package's command instead of LinuxCNC's library.
proc ::ferrule::watch_load {} {
    if {[info commands ::ferrule::load] ne {}} { return }
    rename ::load ::ferrule::load
    proc ::load {args} {
        if {[file tail [lindex $args 0]] eq "hal[info sharedlibextension]"} {
            ::ferrule::keep_hal
            return
        }
        uplevel 1 [list ::ferrule::load {*}$args]
    }
}
