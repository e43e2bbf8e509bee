# Packages of Tcl scripts that use HAL: Ferrule's own, under the names that scripts of LinuxCNC ask for. The versions are above
# those of LinuxCNC's package, so that `package require` takes these where both are installed.

package ifneeded Hal 1.1 [list source [file join $dir hal.tcl]]
package ifneeded hal 1.1 {package require Hal; package provide hal 1.1}
package ifneeded Linuxcnc 1.1 {package require Hal; package provide Linuxcnc 1.1}

# Programs of LinuxCNC's package (`halshow`) look for another package before they call `hal` first.
if {![interp issafe]} {
    source [file join $dir load.tcl]
    ::ferrule::watch_load
}
