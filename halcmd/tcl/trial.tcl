# Executes a Tcl file for `halcmd check`: in a safe interpreter, which starts no program and writes no file. What the file asks of
# the world outside ends the check of the rest of the file, unless the file catches the error.

namespace eval ::ferrule {
    # The safe interpreter.
    variable child {}
    # Contents of files that the script would have written, by name.
    variable written {}
    # What the script printed last.
    variable said {}
    # True if something could not be known.
    variable lost 0
    # Files that are being executed, the innermost last.
    variable sources {}
}

# Executes a file with its arguments, and reports its error.
proc ::ferrule::trial {words} {
    variable child
    variable here
    variable lost
    set child [interp create -safe]
    interp limit $child command -value 5000000
    foreach name {place text passes hal} { copy ::ferrule::$name }
    foreach name {hal parse_ini} { copy ::$name }
    copy ::ferrule::commands
    $child eval [list namespace eval ::ferrule [list variable here $here]]
    $child alias ::ferrule::request ::ferrule::trial_request
    $child eval {rename puts ::ferrule::puts; rename package ::ferrule::package}
    foreach name {puts package source file open after} { $child alias $name ::ferrule::trial_$name }
    foreach name {glob pwd} { $child alias $name ::$name }
    foreach name {exec socket load cd vwait update} { $child alias $name ::ferrule::outside $name }
    foreach name {fconfigure encoding} { $child expose $name }
    $child alias exit ::ferrule::trial_exit
    $child eval [list array set ::env [array get ::env]]
    $child eval {
        foreach name {Hal hal Linuxcnc} { ::ferrule::package provide $name 1.1 }
        ::ferrule::commands
        ::ferrule::passes
        parse_ini
    }
    set file [lindex $words 0]
    $child eval [list set argv0 $file]
    $child eval [list set argv [lrange $words 1 end]]
    $child eval {set argc [llength $argv]}
    set failed [catch {$child eval [list source $file]} text options]
    if {!$failed || $lost} { return }
    set code [dict get $options -errorcode]
    if {[lrange $code 0 1] eq {TCL LIMIT}} {
        request outside $file 0 "it does not end"
        return
    }
    set at [list [file normalize $file] 0]
    regexp {\(file "([^\n]*)" line (\d+)\)} [dict get $options -errorinfo] - path line
    if {[info exists line]} { set at [list [file normalize $path] $line] }
    set number [expr {[lrange $code 0 1] eq {FERRULE LINE} ? [lindex $code 2] : 0}]
    request failed {*}$at $number $text
}

# Makes a procedure of this interpreter known in the safe one.
proc ::ferrule::copy {name} {
    variable child
    $child eval {namespace eval ::ferrule {}}
    $child eval [list proc $name [info args $name] [info body $name]]
}

# Raises the error for a command whose effect is outside, and notes that the rest of the file is not known.
proc ::ferrule::outside {name args} {
    variable child
    variable lost
    set lost 1
    request outside {*}[$child eval ::ferrule::place] "'$name' is not executed in a check"
    return -code error -errorcode {FERRULE UNKNOWN} "'$name' is not executed in a check"
}

# Sends a request of the script. The file that `save` would write is kept here.
proc ::ferrule::trial_request {args} {
    variable written
    variable lost
    if {[lindex $args 0] ne "do" || [lindex $args 3] ne "save" || [llength $args] != 6} {
        set answer [request {*}$args]
        if {[lindex $answer 0] eq "unknown"} { set lost 1 }
        return $answer
    }
    set answer [request {*}[lrange $args 0 4]]
    if {[lindex $answer 0] ne "ok"} { return $answer }
    dict set written [file normalize [lindex $args 5]] [lindex $answer 1]\n
    return {ok {}}
}

proc ::ferrule::trial_source {args} {
    variable child
    $child invokehidden source {*}$args
}

# Keeps what is printed; text for a file goes nowhere.
proc ::ferrule::trial_puts {args} {
    variable child
    variable said
    set words [lsearch -all -inline -not -exact $args -nonewline]
    set channel [expr {[llength $words] > 1 ? [lindex $words 0] : "stdout"}]
    if {$channel in {stdout stderr}} {
        set text [string trim [lindex $words end]]
        if {$text ne {}} { set said $text }
        return
    }
    $child eval [list ::ferrule::puts {*}$args]
}

proc ::ferrule::trial_package {args} {
    variable child
    lassign $args verb name
    if {$verb ni {require present} || $name in {Hal hal Linuxcnc Tcl}} {
        return [$child eval [list ::ferrule::package {*}$args]]
    }
    outside "package $args"
}

# Looks at files, and changes none: words that only read, and with a time behind them set none.
proc ::ferrule::trial_file {verb args} {
    variable written
    set reading {
        atime channels dirname executable exists extension isdirectory isfile join lstat mtime nativename normalize owned
        pathtype readable readlink rootname separator size split stat system tail type volumes writable
    }
    # Words may be shortened.
    set verb [::tcl::prefix match -error {} $reading $verb]
    switch $verb {
        {} { return }
        exists - isfile - readable {
            if {[dict exists $written [file normalize [lindex $args 0]]]} { return 1 }
        }
        atime - mtime { set args [lrange $args 0 0] }
    }
    file $verb {*}$args
}

# Opens a file for reading. What a script writes itself goes nowhere, and is not there when it is read.
proc ::ferrule::trial_open {path {mode r} args} {
    variable child
    variable written
    if {[string index [string trimleft $path] 0] eq "|"} { outside "open $path" }
    set whole [file normalize $path]
    if {$mode ni {r rb}} {
        dict set written $whole {}
        set channel [open /dev/null w]
    } elseif {[dict exists $written $whole]} {
        set channel [file tempfile name]
        file delete $name
        puts -nonewline $channel [dict get $written $whole]
        seek $channel 0
    } else {
        set channel [open $path $mode]
    }
    interp transfer {} $channel $child
    return $channel
}

# Time does not pass.
proc ::ferrule::trial_after {args} {
    if {![string is integer -strict [lindex $args 0]] || [llength $args] > 1} { outside after }
}

# Ends the file. A status other than 0 is an error with what was printed before.
proc ::ferrule::trial_exit {{status 0}} {
    variable child
    variable said
    variable lost
    if {$status ne "0" && !$lost} {
        request failed {*}[$child eval ::ferrule::place] 0 "the file ends with status $status: $said"
    }
    ::exit 0
}
