# Completion of Tenon's apps in bash: options, shipped scenarios, robots and files, keys after --set, and values of keys
# and options that have names.

# Prints the names that a refusal of a value lists: "… one of a, b, c; found" or "… one of a, b, or give the path".
_tenon_names() {
  "$@" 2>&1 </dev/null | sed -n '/one of /{s/.*one of //; s/;.*//; s/, or give .*//; s/,//g; p; q}'
}

_tenon() {
  local app=${COMP_WORDS[0]} at=$COMP_CWORD words scenario key=
  local word=${COMP_WORDS[at]} before=${COMP_WORDS[at - 1]}
  COMPREPLY=()
  # Bash divides KEY=VALUE into three words.
  if [[ $word == = ]]; then
    key=$before word=
  elif [[ $before == = ]]; then
    key=${COMP_WORDS[at - 2]}
  elif [[ $before == --observer || $before == --controller || $before == --gait ]]; then
    key=$before
  fi
  scenario=$("$app" --list 2>/dev/null | sed -n '1s/ .*//p')
  if [[ $key == --* ]]; then
    words=$(_tenon_names "$app" $scenario "$key" _)
  elif [[ -n $key ]]; then
    words=$(_tenon_names "$app" $scenario --keys --set "$key=_")
    COMPREPLY=($(compgen -f -X '!*.yaml' -- "$word"))
  else
    case $before in
      --set)
        words=$("$app" --keys 2>/dev/null | sed 's/ .*/=/; s/\[\]/.0/g')
        compopt -o nospace 2>/dev/null
        ;;
      --out | --graph | --merge | --replay | --estimate | --identify | --video | --frames | --svg | --frame)
        compopt -o default 2>/dev/null
        return
        ;;
      *)
        if [[ $word == -* ]]; then
          words=$("$app" --help 2>/dev/null | grep -oE -- '--[a-z][a-z-]*' | sort -u)
        else
          words=$("$app" --list 2>/dev/null | sed 's/ .*//')
          if [[ -z $words && $app == *-workspace ]]; then words=$(_tenon_names "$app" _); fi
          COMPREPLY=($(compgen -f -X '!*.yaml' -- "$word") $(compgen -d -- "$word"))
        fi
        ;;
    esac
  fi
  COMPREPLY+=($(compgen -W "$words" -- "$word"))
}
complete -F _tenon tenon-campaign tenon-cdpr tenon-cdpr-workspace tenon-gait-stability tenon-guide-dog \
  tenon-quadruped tenon-report tenon-robot
