# Completion of Tenon's apps in bash: options, shipped scenarios and files, keys of scenarios after --set.
_tenon() {
  local app=${COMP_WORDS[0]} word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} words
  COMPREPLY=()
  case $before in
    --set)
      words=$("$app" --keys 2>/dev/null | sed 's/ .*/=/; s/\[\]/.0/g')
      compopt -o nospace 2>/dev/null
      ;;
    --out | --graph | --merge | --replay | --video | --frames | --svg | --frame)
      compopt -o default 2>/dev/null
      return
      ;;
    *)
      if [[ $word == -* ]]; then
        words=$("$app" --help 2>/dev/null | grep -oE -- '--[a-z][a-z-]*' | sort -u)
      else
        words=$("$app" --list 2>/dev/null | sed 's/ .*//')
        COMPREPLY=($(compgen -f -X '!*.yaml' -- "$word") $(compgen -d -- "$word"))
      fi
      ;;
  esac
  COMPREPLY+=($(compgen -W "$words" -- "$word"))
}
complete -F _tenon tenon-campaign tenon-cdpr tenon-cdpr-workspace tenon-gait-stability tenon-guide-dog \
  tenon-observer-order tenon-quadruped tenon-report tenon-robot tenon-tune-pd
