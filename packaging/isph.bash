# Completion of isph's command line in bash: options as -help lists them, names of files elsewhere.
_isph() {
  local word=${COMP_WORDS[COMP_CWORD]}
  if [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W "$("${COMP_WORDS[0]}" -help 2>/dev/null |
      grep -oE '^ *-[a-z][a-z0-9_]*' | sort -u)" -- "$word"))
  else
    COMPREPLY=($(compgen -f -- "$word"))
  fi
}
complete -o filenames -F _isph isph
