#compdef @COMPLETED_COMMANDS@
# Options of the armtrue commands, read from their --help; files elsewhere.
_gnu_generic
