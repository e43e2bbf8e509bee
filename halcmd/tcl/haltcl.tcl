# Executes a Tcl file with the commands of HAL, or what a person types: haltcl [-i INIFILE] [FILE [ARGUMENT...]].
#
# halrun starts it for each `.tcl` file. FERRULE_PASS is the number of the pass with [HAL]TWOPASS; FERRULE_TRIAL is set for
# `halcmd check`, which executes the file where it can affect nothing outside.

source [file join [file dirname [info script]] hal.tcl]
source [file join [file dirname [info script]] load.tcl]

# Makes a command of Tcl for each command of HAL whose name is free.
proc ::ferrule::commands {} {
    set first [expr {[info exists ::env(FERRULE_PASS)] && $::env(FERRULE_PASS) == 0}]
    foreach name [hal --commands] {
        if {[info commands ::$name] ne {}} { continue }
        # The first pass loads and does nothing else.
        if {$first && $name ni {loadrt loadusr}} {
            proc ::$name args {}
        } else {
            proc ::$name args [format {tailcall hal %s {*}$args} $name]
        }
    }
    if {$first} { return }
    # The value is an expression.
    foreach name {setp sets} {
        proc ::$name {name value} [format {
            set value [uplevel 1 [list expr $value]]
            tailcall hal %s $name $value
        } $name]
    }
    proc ::show args { puts [hal show {*}$args] }
}

# Offers what scripts ask during the two passes.
proc ::ferrule::passes {} {
    if {![info exists ::env(FERRULE_PASS)]} { return }
    namespace eval ::tp {}
    proc ::tp::passnumber {} [list return $::env(FERRULE_PASS)]
}

# Executes a file. An error is reported with its place, and ends the program.
proc ::ferrule::run {file} {
    if {![catch {uplevel #0 [list source $file]} text options]} { return }
    # The innermost file of the trace is the one with the error.
    set at [list [file normalize $file] 0]
    regexp {\(file "([^\n]*)" line (\d+)\)} [dict get $options -errorinfo] - path line
    if {[info exists line]} { set at [list [file normalize $path] $line] }
    lassign [dict get $options -errorcode] owner kind number
    if {$owner ne "FERRULE" || $kind ne "LINE"} { set number 0 }
    request failed {*}$at $number $text
    exit 1
}

# Executes what a person types, or lines of standard input.
proc ::ferrule::prompt {} {
    # Only terminals have this option.
    set person [expr {![catch {fconfigure stdin -mode}]}]
    if {$person && ![catch {package require tclreadline}]} {
        namespace eval ::tclreadline { proc prompt1 {} { return "haltcl: " } }
        ::tclreadline::Loop
    }
    set typed {}
    while 1 {
        if {$person} {
            puts -nonewline [expr {$typed eq {} ? "haltcl: " : "haltcl+ "}]
            flush stdout
        }
        if {[gets stdin line] < 0} { exit }
        append typed $line\n
        if {![info complete $typed]} { continue }
        catch {uplevel #0 $typed} text
        if {$text ne {}} { puts $text }
        set typed {}
    }
}

if {[lindex $argv 0] in {-i -ini}} {
    set ::ferrule::ini [lindex $argv 1]
    set argv [lrange $argv 2 end]
}
if {[info exists env(FERRULE_TRIAL)]} {
    source [file join $::ferrule::here trial.tcl]
    ::ferrule::trial $argv
    exit
}
if {[catch {
    ::ferrule::commands
    ::ferrule::passes
    ::ferrule::watch_load
    parse_ini
} text]} {
    puts stderr "haltcl: $text"
    exit 1
}
if {$argv eq {}} { ::ferrule::prompt }
set argv0 [lindex $argv 0]
set argv [lrange $argv 1 end]
set argc [llength $argv]
::ferrule::run $argv0
