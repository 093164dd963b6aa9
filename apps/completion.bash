# Options of the armtrue commands, read from their --help; files elsewhere.
_armtrue() {
  local word=${COMP_WORDS[COMP_CWORD]}
  COMPREPLY=()
  if [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$("$1" --help 2>/dev/null | sed -nE 's/^ {1,4}((-[a-zA-Z],)?--?[a-zA-Z][a-zA-Z0-9-]*).*/\1/p' | tr , '\n')" -- "$word")
  else
    compopt -o filenames 2>/dev/null || true
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  fi
}
complete -F _armtrue @COMPLETED_COMMANDS@
