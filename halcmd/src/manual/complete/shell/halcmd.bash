# Completion of the programs for bash:  eval "$(halcmd completion bash)"
_ferrule() {
    local out status
    out=$(COMP_LINE=$COMP_LINE COMP_POINT=$COMP_POINT halcmd -C "$1" "$2" "$3" 2>/dev/null)
    status=$?
    COMPREPLY=()
    [[ -n $out ]] && mapfile -t COMPREPLY <<<"$out"
    case ${COMPREPLY[0]-} in
        *=) compopt -o nospace ;;
    esac
    [[ $status == 3 ]] && compopt -o default -o filenames
    return 0
}
complete -F _ferrule halcmd halrun halscope haltest halgcode halsampler halstreamer halsetup haltcl latency-test linuxcnc hal_manualtoolchange
