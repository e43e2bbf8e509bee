printf 'print one\nnonsense\nprint two\n' | halrun --instance b --virtual 2>&1
echo "status $?"
printf 'print one\nquit\nprint two\n' | halrun --instance b --virtual -s 2>&1
echo "status $?"
printf 'print typed\ngetp t.threadbeat\nrun 2ms\ngetp t.threadbeat\nnonsense\n' | halrun --instance b --virtual -I one.hal 2>&1
echo "status $?"
printf 'getp t.threadbeat\nrun 3ms\ngetp t.threadbeat\n' | HAL_CLOCK=virtual HAL_INSTANCE=b HAL_HOLD=1 halrun -I one.hal 2>&1
echo "status $?"
HAL_CLOCK=virtual HAL_INSTANCE=b HAL_FOR=2ms HAL_RECORD=short.vcd halrun one.hal </dev/null 2>&1
echo "status $?"
