# Completion of contourctl in bash. The program itself prints the words; a line that begins with a slash stands for
# files with that suffix.

_contourctl() {
  local line suffix folders='' word=${COMP_WORDS[COMP_CWORD]}
  COMPREPLY=()
  # Without words, bash completes file names. compgen -W is not used: it would expand commands in a job's name.
  while IFS= read -r line; do
    case $line in
      /) ;;
      /*)
        suffix=${line#/}
        mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(
          [[ $folders ]] || compgen -d -- "$word"
          compgen -f -X "!*$suffix" -- "$word"
          compgen -f -X "!*${suffix^^}" -- "$word"
        )
        folders=offered
        ;;
      *) COMPREPLY+=("${line%%$'\t'*}") ;;
    esac
  done < <(contourctl complete -- "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
}
complete -o default -o filenames -F _contourctl contourctl
