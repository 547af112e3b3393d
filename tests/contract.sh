#!/usr/bin/env bash
# Sixty seconds of schemathesis against the built server: what openapi.json allows is served, what it does not is
# refused, nothing is a server error. Left out, and said so, where Python or the packages cannot be had: that the
# schemas and the checks agree is tested by lab/tests/schemas.rs too, with Rust alone.
set -euo pipefail
cd "$(dirname "$0")/.."
readonly VERSION=4.32.5 SECONDS_LONG=${1:-60} PLACE=$PWD/target/schemathesis CONTRACT=$PWD/openapi/openapi.json

left_out() { echo "schemathesis is LEFT OUT: $1"; exit 0; }

if [ ! -x "$PLACE/bin/schemathesis" ]; then
  command -v python3 > /dev/null || left_out 'there is no python3'
  python3 -m venv "$PLACE" > /dev/null 2>&1 || left_out 'python3 has no venv'
  "$PLACE/bin/pip" install --quiet "schemathesis==$VERSION" > "$PLACE/pip.log" 2>&1 ||
    { tail -n 3 "$PLACE/pip.log"; rm -rf "$PLACE"; left_out 'its packages cannot be fetched'; }
fi

work=$(mktemp -d); server=
trap '[ -z "$server" ] || kill "$server" 2> /dev/null || true; rm -rf "$work"' EXIT
target/debug/umwelt-server --listen 127.0.0.1:0 --data "$work/data" --evolution-threads 1 \
  > "$work/out" 2> "$work/log" & server=$!
for _ in $(seq 100); do
  url=$(sed -n 's/^listening on //p' "$work/out"); [ -n "$url" ] && break; sleep 0.1
done
[ -n "$url" ] || { cat "$work/log"; exit 1; }
for robot in r1 r2 r3; do
  python3 - "$url/v1/robots/$robot" <<'PYTHON'
import sys, urllib.request
request = urllib.request.Request(sys.argv[1], b"{}", {"Content-Type": "application/json"}, method="PUT")
urllib.request.urlopen(request, timeout=10).close()
PYTHON
done
# Event streams do not end.
cd "$work" # It leaves files where it runs.
"$PLACE/bin/schemathesis" run "$CONTRACT" --url "$url" --checks all --max-examples 40 \
  --max-time "$SECONDS_LONG" --seed 1 --generation-database none --request-timeout 10 --workers 1 \
  --continue-on-failure --exclude-path-regex 'events$' --no-color > "$work/found" 2>&1 ||
  { cut -c 1-1000 "$work/found"; exit 1; }
tail -n 4 "$work/found"
if grep -q panicked "$work/log"; then grep -A 5 panicked "$work/log"; exit 1; fi
