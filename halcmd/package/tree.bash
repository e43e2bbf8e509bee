# The tree that packages and `install` put on a computer. Sourced; the caller sets:
#   release   folder with the programs of `cargo build --release`
#   root      folder below which the tree is made
#   prefix    /usr for packages, /usr/local or any other for `install`
# Programs look for plugins, Python modules and Tcl files beside themselves, so all of it is one folder, and the path has links.
package=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
top=$(cd "$package/../.." && pwd)
# Of cargo, which takes a relative path as one from its own folder.
target=$(cd "$top" && realpath -m "${CARGO_TARGET_DIR:-target}")

version_of() { sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' "$top/Cargo.toml"; }
# The day of the newest entry of the changelog: pages and archives are the same whenever they are made.
day_of() { sed -n 's/^## [0-9][^ ]* (\(.*\))$/\1/p' "$package/CHANGELOG.md" | head -n 1; }

# Programs whose names LinuxCNC's packages have too.
shared_names=(hal_manualtoolchange halcmd halcompile halrun halsampler halscope halshow halstreamer haltcl latency-test linuxcnc linuxcncrsh)
panel_programs=(halpanel)

is_program() { [ -f "$1" ] && [ -x "$1" ] && [[ $1 != *.so ]]; }
# All programs of the release folder, and all plugins: the library of macros runs in the compiler, that of Python elsewhere.
programs() { local f; for f in "$release"/*; do is_program "$f" && basename "$f"; done; }
plugins() {
    local f
    for f in "$release"/lib*.so; do
        case $(basename "$f") in libhal_derive.so | libferrule_python.so) ;; *) basename "$f" ;; esac
    done
}

put() { install -D -m "$1" "$2" "$root$3"; }
is_panel() { local p; for p in "${panel_programs[@]}"; do [ "$p" = "$1" ] && return 0; done; return 1; }
is_shared() { local p; for p in "${shared_names[@]}"; do [ "$p" = "$1" ] && return 0; done; return 1; }

# Copies a program or library, without what only debuggers read.
put_code() {
    put "$1" "$2" "$3"
    [ -z "${debug_root-}" ] || keep_debug "$root$3"
    strip --strip-unneeded --remove-section=.comment --remove-section=.note "$root$3"
}
# Puts what debuggers read where they look for it: by the number of the build.
keep_debug() {
    local id
    id=$(readelf -n "$1" | sed -n 's/.*Build ID: //p')
    [ -n "$id" ] || { echo "$1 has no build id: debuggers do not find its symbols" >&2; return 1; }
    local file=$debug_root/usr/lib/debug/.build-id/${id:0:2}/${id:2}.debug
    mkdir -p "$(dirname "$file")"
    objcopy --only-keep-debug --compress-debug-sections "$1" "$file"
    chmod 644 "$file"
}

page() { # SECTION NAME < page
    local file=$root$prefix/share/man/man$1/$2.$1ferrule
    mkdir -p "$(dirname "$file")"
    gzip -9n > "$file.gz"
}

# Programs, with their pages and completions. Words: the programs.
tree_programs() {
    local p bin=$prefix/lib/ferrule/bin
    for p in "$@"; do
        put_code 755 "$release/$p" "$bin/$p"
        if [ "$p" = halcmd ]; then
            sed "s/^\.TH HALCMD 1 \"\"/.TH HALCMD 1ferrule \"$(day_of)\"/" "$package/../halcmd.1" | page 1 halcmd
        elif [ "$p" = halshow ]; then
            # A program of Tcl in a window: without one it has no help.
            printf '.TH HALSHOW 1ferrule "%s" Ferrule "Ferrule"\n.SH NAME\nhalshow \\- shows the tree of components, pins and signals of an instance\n.SH SYNOPSIS\n.B halshow\n.SH DESCRIPTION\nLinuxCNC'"'"'s program of that name, from its package, for a running instance of Ferrule. It needs a display, tk and bwidget.\n.SH SEE ALSO\n.BR halcmd (1ferrule)\n' "$(day_of)" | page 1 halshow
        else
            PAGE_DATE=$(day_of) "$package/from-help" man "$release/$p" | page 1 "$p"
        fi
    done
}

# Links in the path. Words: the programs.
tree_links() {
    local p
    mkdir -p "$root$prefix/bin"
    for p in "$@"; do ln -s "../lib/ferrule/bin/$p" "$root$prefix/bin/$p"; done
}

# Completion of the programs that complete themselves by `halcmd -C` ...
tree_completion_of_halcmd() {
    local p line bash=$prefix/share/bash-completion/completions
    line=$("$release/halcmd" completion bash | sed -n 's/^complete -F _ferrule //p')
    mkdir -p "$root$bash" "$root$zsh" "$root$fish"
    "$release/halcmd" completion bash > "$root$bash/halcmd"
    for p in $line; do [ "$p" = halcmd ] || ln -s halcmd "$root$bash/$p"; done
    "$release/halcmd" completion zsh > "$root$zsh/_halcmd"
    # Fish reads a file when its program is completed first.
    for p in $line; do "$release/halcmd" completion fish > "$root$fish/$p.fish"; done
}
# ... and of those whose --help tells all.
tree_completion() {
    local p bash=$prefix/share/bash-completion/completions
    mkdir -p "$root$bash" "$root$zsh" "$root$fish"
    for p in "$@"; do
        "$package/from-help" bash "$release/$p" > "$root$bash/$p"
        "$package/from-help" zsh "$release/$p" > "$root$zsh/_$p"
        "$package/from-help" fish "$release/$p" > "$root$fish/$p.fish"
    done
}

# The pages of the components: each component of the plugins, from what its plugin says.
tree_components() {
    local name
    for name in $(COMP_LINE='halcmd man ' HAL_RTMOD_DIR="$release" "$release/halcmd" -C 2>/dev/null | sort -u); do
        case $name in -* | */*) continue ;; esac
        "$release/halcmd" man --roff "$name" | sed "1,2s/^\(\.TH \"[^\"]*\"\) 9 \"\"/\1 9ferrule \"$(day_of)\"/" | page 9 "$name"
    done
}

unit() { # FILE [NAME]
    local file=$root$units/${2:-$1}
    mkdir -p "$(dirname "$file")"
    sed "s#@BIN@#$prefix/lib/ferrule/bin#" "$package/system/$1" > "$file"
    chmod 644 "$file"
}

# Everything but the panel, Python and the manual.
tree_ferrule() {
    local p all=() own=()
    for p in $(programs); do is_panel "$p" || all+=("$p"); done
    tree_programs "${all[@]}"
    for p in "${all[@]}"; do is_shared "$p" || own+=("$p"); done
    tree_links "${own[@]}"
    for p in $(plugins); do put_code 644 "$release/$p" "$prefix/lib/ferrule/bin/$p"; done
    for p in "$release"/tcl/*; do put 644 "$p" "$prefix/lib/ferrule/bin/tcl/$(basename "$p")"; done
    (cd "$top/components/foreign/compat/include" && find . -name '*.h') | while read -r p; do
        put 644 "$top/components/foreign/compat/include/$p" "$prefix/include/ferrule/${p#./}"
    done
    tree_components
    tree_completion_of_halcmd
    local clap=()
    local known=" $("$release/halcmd" completion bash | sed -n 's/^complete -F _ferrule //p') "
    for p in "${all[@]}"; do [[ $known == *" $p "* ]] || [ "$p" = halshow ] || clap+=("$p"); done
    tree_completion "${clap[@]}"
    unit ferrule@.service
    put 644 "$package/system/ferrule.sysusers" "$sysusers/ferrule.conf"
    put 644 "$package/system/ferrule.rules" "$udev/60-ferrule.rules"
    put 644 "$package/system/ferrule.limits" /etc/security/limits.d/ferrule.conf
}

tree_panel() {
    tree_programs "${panel_programs[@]}"
    tree_links "${panel_programs[@]}"
    tree_completion "${panel_programs[@]}"
    unit ferrule-panel@.service
    unit panel.conf ferrule@.service.d/panel.conf
    put 644 "$package/system/ferrule-panel.sysusers" "$sysusers/ferrule-panel.conf"
}

# The modules lie beside halrun: LinuxCNC's package has modules of the same names on Python's own path.
tree_python() {
    local f bin=$prefix/lib/ferrule/bin
    (cd "$top/components/foreign/python/modules" && find . -type f -not -path '*/__pycache__/*') | while read -r f; do
        put 644 "$top/components/foreign/python/modules/$f" "$bin/python/${f#./}"
    done
    put_code 644 "$release/libferrule_python.so" "$bin/python/ferrule/_library.abi3.so"
}
