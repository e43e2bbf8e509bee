# Completion of the programs for fish:  halcmd completion fish | source
function __ferrule_complete
    set -lx HAL_COMPLETE about
    set -lx COMP_LINE (commandline -cp)
    halcmd -C 2>/dev/null
    if test $status -eq 3
        __fish_complete_path (commandline -ct)
    end
end
for program in halcmd halrun halscope haltest halgcode halsampler halstreamer halsetup haltcl latency-test linuxcnc hal_manualtoolchange
    complete -c $program -f -a '(__ferrule_complete)'
end
