# gaitslam completion for bash. The commands and options come from the program's own help.
_gaitslam() {
  local current=${COMP_WORDS[COMP_CWORD]} program=${COMP_WORDS[0]} command= word
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    case $word in -*) ;; *) command=$word; break ;; esac
  done
  COMPREPLY=()
  if [ -z "$command" ] && [ "$COMP_CWORD" = 1 ]; then
    mapfile -t COMPREPLY < <(compgen -W "--help --version $("$program" --help 2>/dev/null |
      sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p')" -- "$current")
  elif [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$("$program" "$command" --help 2>/dev/null |
      grep -o -E '^  (-[a-zA-Z],)?--[a-z][a-z-]*' | grep -o -E -- '--[a-z][a-z-]*')" -- "$current")
  fi
}
complete -o default -F _gaitslam gaitslam
