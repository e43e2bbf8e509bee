# Time stands still while lines are carried out: when it moves, waitusr waits.
until [ "$(halcmd getp t.threadbeat)" -gt 100 ]; do :; done
halcmd unloadusr hal_manualtoolchange
