# Asks for each line as bash does.
while IFS= read -r line; do
    words=$(COMP_LINE="$line" COMP_POINT=${#line} halcmd -C)
    status=$?
    echo "$line|" $words $([ $status = 3 ] && echo "(files)")
done < lines
# What bash takes for the word begins after the equals sign.
COMP_LINE='halcmd motion.enable --w' halcmd -C halcmd --w motion.enable
COMP_LINE='halcmd record of' COMP_POINT=12 halcmd -C
COMP_LINE='halcmd net both and' HAL_COMPLETE=about halcmd -C
for shell in bash zsh fish; do halcmd completion $shell | grep -c 'halcmd -C'; done
