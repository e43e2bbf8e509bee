# The package Hal: the command `hal`, which executes HAL commands in a running instance, and `parse_ini`.
#
# Requests go to halrun, through the pipes whose numbers are in FERRULE_TCL, or to a halcmd that this script starts. A request
# is a line with its number of strings, and each string behind a line with its length in bytes. An answer has the same form; its
# first string is `ok`, `error` or `unknown`.

namespace eval ::ferrule {
    # Folder of the package.
    variable here [file dirname [file normalize [info script]]]
    # Channels of requests and answers; empty before the first request.
    variable to {}
    variable from {}
    # INI file of the halcmd that is started.
    variable ini {}
}

# Opens the channels.
proc ::ferrule::connect {} {
    variable to
    variable from
    variable ini
    if {[info exists ::env(FERRULE_TCL)]} {
        lassign $::env(FERRULE_TCL) in out
        # The pipes are this script's own; programs that it starts connect themselves.
        unset ::env(FERRULE_TCL)
        set from [open /dev/fd/$in r]
        set to [open /dev/fd/$out w]
    } else {
        set command [list [halcmd] --tcl]
        if {$ini ne {}} { lappend command -i $ini }
        set to [open |[concat $command {2>@ stderr}] r+]
        set from $to
    }
    foreach channel [list $from $to] {
        fconfigure $channel -translation binary -buffering full
    }
}

# Returns the path of the halcmd that belongs to this package.
proc ::ferrule::halcmd {} {
    variable here
    set beside [file join [file dirname $here] halcmd]
    set installed [file join $here .. .. .. bin halcmd]
    foreach path [list $beside $installed] {
        if {[file executable $path]} { return [file normalize $path] }
    }
    error "Ferrule's halcmd is neither '$beside' nor '$installed'"
}

# Sends a request, and returns the strings of the answer.
proc ::ferrule::request {args} {
    variable to
    variable from
    if {$to eq {}} { connect }
    set text "[llength $args]\n"
    foreach word $args {
        set bytes [encoding convertto utf-8 $word]
        append text [string length $bytes] \n $bytes
    }
    if {[catch {puts -nonewline $to $text; flush $to}] || [gets $from count] < 0} {
        error "the machine has ended"
    }
    set answer {}
    while {[incr count -1] >= 0} {
        gets $from length
        lappend answer [encoding convertfrom utf-8 [read $from $length]]
    }
    return $answer
}

# Returns the text of an answer, or raises its error.
proc ::ferrule::text {answer} {
    lassign $answer kind text number
    switch $kind {
        ok { return $text }
        unknown { return -code error -level 2 -errorcode {FERRULE UNKNOWN} $text }
        default { return -code error -level 2 -errorcode [list FERRULE LINE $number] $text }
    }
}

# Returns the file and the line of the command that is being executed, outside of this package.
proc ::ferrule::place {} {
    variable here
    for {set n [info frame]} {$n > 0} {incr n -1} {
        set frame [info frame $n]
        if {[dict get $frame type] ne "source"} { continue }
        set file [dict get $frame file]
        if {[file dirname $file] ne $here} { return [list $file [dict get $frame line]] }
    }
    return {{} 0}
}

# Executes a HAL command given as words, and returns what it prints and what it did.
proc ::ferrule::hal {args} {
    switch -- [lindex $args 0] {
        {} { return -code error {wrong # args: should be "hal command ..."} }
        --commands { return [lrange [request commands] 1 end] }
    }
    text [request do {*}[place] {*}$args]
}

proc hal args { tailcall ::ferrule::hal {*}$args }

# Makes an array for each section of an INI file. An element is the list of the values of its entries. Without a file, the
# entries are those of the INI file that the instance was started with.
proc parse_ini {args} {
    if {[llength $args] > 1} { return -code error {wrong # args: should be "parse_ini filename"} }
    set answer [::ferrule::request ini {*}$args]
    if {[lindex $answer 0] ne "ok"} { ::ferrule::text $answer }
    foreach {section name value} [lrange $answer 1 end] {
        upvar 1 $section entries
        lappend entries($name) $value
    }
}

package provide Hal 1.1
