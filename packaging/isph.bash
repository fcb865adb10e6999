# Completion of isph's command line in bash: names of options, values that are names, files
# elsewhere. All names come from the reference page that the program prints.
_isph() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} names
  names=$("${COMP_WORDS[0]/#\~/$HOME}" -options_reference 2>/dev/null |
    awk -v word="$word" -v before="$before" '
      BEGIN { k = match(word, /[0-9]+/) ? substr(word, RSTART, RLENGTH) : "<k>" }
      # `<side>` stands for left, right, bottom, top.
      /^`<.*> *` stands for / {
        place = $1; gsub(/`/, "", place)
        list = $0; sub(/.* stands for /, "", list); sub(/\.$/, "", list)
        places[place] = list
      }
      # Prints the name of an option, or its beginning up to a word of the user.
      function print_name(name,    list, place, n, q) {
        for (place in places) if (index(name, place)) {
          n = split(places[place], list, ", ")
          for (q = 1; q <= n; q++) print_name(replaced(name, place, list[q]))
          return
        }
        name = replaced(name, "<k>", k)
        sub(/<.*/, "", name)
        print name
      }
      function replaced(name, part, other,    at) {
        at = index(name, part)
        return at ? substr(name, 1, at - 1) other substr(name, at + length(part)) : name
      }
      /^\| `-/ {
        split($0, cells, / \|/); name = cells[1]; gsub(/[|` ]/, "", name)
        if (word ~ /^-/) print_name(name)
        else if (name == before && match($0, /(one|some) of [^|]*/)) {
          list = substr($0, RSTART, RLENGTH); sub(/^(one|some) of /, "", list)
          gsub(/[\\,]/, "", list); print list
        }
      }' | sort -u)
  COMPREPLY=($(compgen -W "$names" -- "$word"))
  if [[ ${COMPREPLY[0]} == *_ ]]; then compopt -o nospace 2>/dev/null; fi
  if [[ -z $names && $word != -* ]]; then
    compopt -o filenames 2>/dev/null
    COMPREPLY=($(compgen -f -- "$word"))
  fi
}
complete -F _isph isph
