#!/bin/sh
# Records a walk and reads it by Foxglove's readers. usage: read_mcap.sh TENON_QUADRUPED DIRECTORY
# Exits with 77, skipped, if the readers are not there and npm cannot install them.
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$2"
if [ ! -d "$2/node_modules/@mcap/core" ]; then
  npm install --prefix "$2" --no-audit --no-fund @mcap/core@2 @foxglove/rosmsg@5 @foxglove/rosmsg2-serialization@3 || exit 77
fi
"$1" flat --duration 3 --mcap --out "$2/flat" > "$2/log" 2>&1
[ -f "$2/flat/run.mcap" ] || { cat "$2/log"; exit 1; }
exec node "$here/read_mcap.mjs" "$2/node_modules" "$2/flat/run.mcap"
