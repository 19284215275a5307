# Completion of contourctl in bash. Commands and options come from the program's --help; jobs and resins are the
# existing ones.

_contourctl_words() {
  local name
  case $1 in
    commands) contourctl "${@:2}" --help 2>/dev/null | sed -n '/^Subcommands:/,$ s/^  \([a-z-]*\) .*/\1/p' ;;
    options) contourctl "${@:2}" --help 2>/dev/null | grep -oE '^ +(-[a-z],)?--[a-z,-]+' | grep -oE -- '--[a-z-]+' ;;
    jobs)
      contourctl status 2>/dev/null | sed -n 's/^job  *//p'
      _contourctl_words waiting
      ;;
    ended) contourctl history --csv 2>/dev/null | sed -nE '1d; s/^"(([^"]|"")*)",.*/\1/; s/""/"/g; p' | sort -u ;;
    waiting) contourctl queue 2>/dev/null | sed -n 's/^ *[0-9][0-9]*  \(.*\)\.[^.]*$/\1/p' ;;
    asking)
      contourctl queue 2>/dev/null |
        sed -nE '/^ *[0-9]+  /{s/^ *[0-9]+  (.*)\.[^.]*$/\1/;h}; /^     waits to be accepted/{x;p}'
      ;;
    resins)
      for name in /etc/contourd/resins/*.json; do
        name=${name##*/}
        [[ $name == '*.json' ]] || echo "${name%.json}"
      done
      ;;
  esac
}

_contourctl() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words='' length=1 each
  if [[ ${COMP_WORDS[1]} == queue && $COMP_CWORD == 3 && $word != -* ]]; then before=queue-job; fi
  if [[ $before == preview && $COMP_CWORD == 2 && $word != -* ]]; then before=preview-job; fi
  if [[ $before == logs && $COMP_CWORD == 2 && $word != -* ]]; then before=--job; fi
  if [[ $before == accept && $COMP_CWORD == 2 && $word != -* ]]; then before=asking-job; fi
  case $before in
    asking-job) words=$(_contourctl_words asking) ;;
    help) words=$(_contourctl_words commands) ;;
    queue-job) words=$(_contourctl_words waiting) ;;
    preview-job)
      words=$(_contourctl_words jobs; _contourctl_words ended)
      words+=$'\n'$(compgen -d -- "$word")$'\n'$(compgen -f -X '!*.[sS][tT][lL]' -- "$word")
      ;;
    --job) words=$(_contourctl_words jobs) ;;
    --resin) words=$(_contourctl_words resins) ;;
    schema) words=$'plate\nprinter\nprojector\nresin\nticket' ;;
    --preset|--up) words=$'auto\nfast\nclean\nsafe' ;;
    --aa) words=$'on\noff' ;;
    --outcome) words=$'done\nfailed\ncancelled' ;;
    replaced) words=$'lamp\nfilm\nvat' ;;
    show) words=$'white\nblack\ngrid\nchecker\nfocus\nborder\ndimensions' ;;
    *)
      # The command: one word, or two.
      if [[ ${COMP_WORDS[1]} == @(motor|light|projector|queue|config) ]]; then length=2; fi
      if ((COMP_CWORD <= length)); then
        words=$(_contourctl_words commands "${COMP_WORDS[@]:1:COMP_CWORD-1}")
      elif [[ $word == -* ]]; then
        words=$(_contourctl_words options "${COMP_WORDS[@]:1:length}")
      fi
      ;;
  esac
  # Without words, bash completes file names. compgen -W is not used: it would expand commands in a job's name.
  COMPREPLY=()
  while read -r each; do
    if [[ -n $each && $each == "$word"* ]]; then COMPREPLY+=("$each"); fi
  done <<<"$words"
}
complete -o default -o filenames -F _contourctl contourctl
