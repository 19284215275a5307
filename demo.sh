#!/usr/bin/env bash
# Prints a model on the simulated printer: ./demo.sh [--pace realtime|fast] [MODEL]
# Without a model it makes one: a gyroid in a ball.
set -euo pipefail

usage() {
  echo "usage: ./demo.sh [--pace realtime|fast] [MODEL]" >&2
  exit 64
}
pace=fast
model=
while (($#)); do
  case $1 in
    --pace) pace=${2-}; shift $(($# > 1 ? 2 : 1)); [[ $pace == realtime || $pace == fast ]] || usage ;;
    -*) usage ;;
    *) [[ -z $model ]] || usage; model=$1; shift ;;
  esac
done
if [[ -n $model ]]; then
  [[ -f $model && -r $model ]] || { echo "demo.sh: cannot read $model" >&2; exit 66; }
  model=$(realpath -- "$model")
fi

cd "$(dirname "$0")"
echo "This installs the missing Debian packages and compiles contourd; the amount of each is shown before it begins."
.ci/install-packages
.ci/build build -- contourd contourctl make-model
bin=$PWD/build/bin

# All files of this print are in one private folder, which is kept.
folder=$(mktemp -d "${TMPDIR:-/tmp}/contourd-demo.XXXXXX")
cp -r config/. "$folder"
mkdir -p "$folder/spool/incoming"
if [[ -z $model ]]; then
  model=$folder/gyroid-in-a-ball.stl
  "$bin/make-model" gyroid-sphere "$model" 64 >/dev/null
fi
layers='\.(sl1|sl1s|sl1_svg|nanodlp)$'  # the names of files with finished layers
# Refuses a file that is not a model before anything is started. An archive of several models, or of layers, can only be
# printed.
if inspected=$("$bin/contourctl" inspect "$model" 2>"$folder/inspect.log"); then
  cat "$folder/inspect.log" >&2
elif [[ ! ${model,,} =~ \.zip$ && ! ${model,,} =~ $layers ]]; then
  cat "$folder/inspect.log" >&2
  rm -r "$folder"
  exit 65
fi
# The model for the commands that README.md shows. Layers are none.
[[ $model -ef build/part.stl || ${model,,} =~ $layers ]] || cp -- "$model" build/part.stl

"$bin/contourd" --config "$folder/simulated.json" --pace "$pace" >"$folder/contourd.log" 2>&1 &
daemon=$!
trap 'kill "$daemon" 2>/dev/null && wait "$daemon" || true' EXIT
export CONTOURD_SOCKET=$folder/control.sock
for ((tries = 0; tries < 100; tries++)); do
  "$bin/contourctl" status >/dev/null 2>&1 && break
  kill -0 "$daemon" 2>/dev/null || { cat "$folder/contourd.log" >&2; exit 1; }
  sleep 0.1
done

file=$(basename -- "$model")
case ${file,,} in
  *.stl.gz | *.obj.gz | *.amf.gz) name=${file%.*.*} ;;
  *.stl | *.obj | *.3mf | *.amf | *.zip | *.sl1 | *.sl1s | *.sl1_svg | *.nanodlp) name=${file%.*} ;;
  *) name=${file%.*} file=${file%.*}.stl ;;
esac
# A model larger than the machine is scaled to it; its size is the line "size X x Y x Z mm".
if [[ ${file,,} =~ $layers ]]; then
  echo "Printing $name, as it was sliced"
elif awk '$1 == "size" && ($2 > 96 || $4 > 54 || $6 > 150) { exit 1 }' <<<"$inspected"; then
  echo "Printing $name"
  # contourd would ask whether a tiny model is in millimetres, and wait.
  echo '{"unit": "mm"}' >"$folder/spool/incoming/$name.json"
else
  echo "Printing $name, scaled to fit the simulated printer (96 x 54 x 150 mm)"
  echo '{"fit": true}' >"$folder/spool/incoming/$name.json"
fi
cp -- "$model" "$folder/spool/incoming/$file"

if ! "$bin/contourctl" watch --job "$name"; then
  printf '\nThe print failed. Log: %s\n' "$folder/contourd.log"
  exit 1
fi
if [[ ! -e $folder/spool/done/$name.report.html ]]; then
  echo "The view was left before the end of the print, which is stopped."
  exit
fi
echo
printf '%-9s%s\n' \
  Masks "$folder/masks/$name/ ($(find "$folder/masks/$name" -name '*.png' | wc -l) PNG files)" \
  Preview "$folder/spool/done/$name.preview.png" \
  Report "$folder/spool/done/$name.report.html" \
  '' "$folder/spool/done/$name.report.json" \
  Log "$folder/contourd.log"
[[ ${model,,} =~ $layers ]] || printf '%-9s%s\n' Model "build/part.stl, for the commands in README.md"
