#!/usr/bin/env bash
# The page of `lacquer compare` in headless Chromium: tests/report/run.sh LACQUER|DIR/report.html [SCREENSHOTS]
#   LACQUER           compares three estimators on a small scene, then checks the page of that
#   DIR/report.html   checks this page against results.json beside it
# Needs chromium, node and npm (for playwright-core, see package.json); says that it skips where they are missing.
# Ends with a line "N passed, M failed" or "0 passed, 0 failed, 1 skipped".
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
subject=${1:?usage: tests/report/run.sh LACQUER|DIR/report.html [SCREENSHOTS]}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
screenshots=${2:-$work/screenshots}

skip() { echo "SKIP the report's page: $1"; echo "0 passed, 0 failed, 1 skipped"; exit 0; }
for program in node npm; do command -v "$program" >/dev/null || skip "$program is not installed"; done
command -v chromium >/dev/null || command -v chromium-browser >/dev/null || command -v google-chrome >/dev/null ||
    skip "chromium is not installed"
if [ ! -d "$here/node_modules/playwright-core" ]; then
    (cd "$here" && npm ci --no-audit --no-fund >"$work/npm.log" 2>&1) || skip "npm cannot install playwright-core"
fi

report=$subject
if [[ $subject != *.html ]]; then
    report=$work/comparison/report.html
    "$subject" compare "$here/../../scenes/xia2020/fig05-sphere.pbrt" --estimators bidirectional,pairproduct,halfvector \
        --equal-samples 4 --runs 3 --reference-spp 32 --reference-estimator pairproduct --resolution 128x128 \
        --box ball:31,97,26,95 --box highlight:28,67,26,59 --out "$work/comparison" >"$work/compare.log" 2>&1 ||
        { cat "$work/compare.log"; echo "0 passed, 1 failed"; exit 1; }
fi
node "$here/check_report.mjs" "$report" "$screenshots"
