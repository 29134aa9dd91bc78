#!/usr/bin/env bash
# The pages of reports in headless Chromium: tests/report/run.sh LACQUER|DIR/report.html [SCREENSHOTS]
#   LACQUER           makes small reports of `lacquer compare` (three estimators; two integrators; two denoisers) and of `lacquer bulk` (clusters, one
#                     sphere, a method without clusters, an oriented ensemble), of `lacquer estimate` (layers) and of `lacquer capture`, then checks
#                     their pages, and those of made-up estimates that the unit tests of the same build write, if there are any
#   DIR/report.html   checks this page, that of a comparison against results.json beside it
# Needs chromium, node and npm (for playwright-core, see package.json); says that it skips where they are missing.
# Ends with a line "N passed, M failed" or "0 passed, 0 failed, 1 skipped".
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
subject=${1:?usage: tests/report/run.sh LACQUER|DIR/report.html [SCREENSHOTS]}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
screenshots=${2:-$work/screenshots}

skip() { echo "SKIP the reports' pages: $1"; echo "0 passed, 0 failed, 1 skipped"; exit 0; }
for program in node npm; do command -v "$program" >/dev/null || skip "$program is not installed"; done
command -v chromium >/dev/null || command -v chromium-browser >/dev/null || command -v google-chrome >/dev/null ||
    skip "chromium is not installed"
if [ ! -d "$here/node_modules/playwright-core" ]; then
    (cd "$here" && npm ci --no-audit --no-fund >"$work/npm.log" 2>&1) || skip "npm cannot install playwright-core"
fi

reports=()
# make NAME ARGUMENTS...: a report by the program, in a folder of this name
make() {
    local name=$1
    shift
    "$subject" "$@" >"$work/$name.log" 2>&1 || { cat "$work/$name.log"; echo "0 passed, 1 failed"; exit 1; }
    reports+=("$work/$name/report.html")
}
# bulk NAME ARRANGEMENT METHOD: small particles of two kinds
bulk() {
    cat >"$work/$1.json" <<EOF
{"wavelengths": [400, 700, 150], "host": {"index": 1.33},
 "species": [{"name": "fat <b>", "index": 1.46, "radius": 0.1, "volume fraction": 0.04},
             {"name": "casein", "index": [1.52, 0.01], "radius": 0.06, "volume fraction": 0.01}],
 "arrangement": $2, "method": "$3"}
EOF
    make "$1" bulk "$work/$1.json" --realisations 8 --out "$work/$1-table.json" --report "$work/$1"
}

if [[ $subject == *.html ]]; then
    reports=("$subject")
else
    make comparison compare "$here/../../scenes/xia2020/fig05-sphere.pbrt" --estimators bidirectional,pairproduct,halfvector \
        --equal-samples 4 --runs 3 --reference-spp 32 --reference-estimator pairproduct --resolution 64x64 \
        --box ball:15,49,13,48 --box highlight:14,34,13,30 --out "$work/comparison"
    make integrators compare "$here/../../scenes/xia2020/fig05-sphere.pbrt" --integrators path,bdpt --equal-samples 4 \
        --runs 2 --reference-spp 32 --resolution 64x64 --box ball:15,49,13,48 --out "$work/integrators"
    make denoisers compare "$here/../../scenes/xia2020/fig05-sphere.pbrt" --denoisers none,nfor --equal-samples 4 \
        --runs 2 --reference-spp 32 --resolution 64x64 --box ball:15,49,13,48 --out "$work/denoisers"
    bulk clusters '{"kind": "cut", "count": 8, "mode": "medium"}' clusters
    bulk one '{"kind": "uniform", "count": 1, "mode": "aggregate"}' clusters
    bulk oriented '{"kind": "disc", "deviations": [0.3, 0.3, 0.08], "count": 6, "mode": "aggregate", "oriented": true,
        "incidences": 7, "azimuths": 13}' clusters
    bulk structure '{"kind": "uniform", "count": 8, "mode": "medium"}' structure
    cat >"$work/varnish.pbrt" <<EOF
WorldBegin
MakeNamedMaterial "coat" "string type" "dielectric" "float roughness" 0.2 "bool remaproughness" false
MakeNamedMaterial "slab" "string type" "slab" "rgb sigma_t" [.4 .2 .1]
MakeNamedMaterial "base" "string type" "diffuse" "rgb reflectance" [.7 .5 .3]
MakeNamedMaterial "varnish" "string type" "layered" "string stack" ["coat" "slab" "base"]
EOF
    layers=(--scene "$work/varnish.pbrt" --free coat.roughness,slab.sigma_t)
    "$subject" estimate "${layers[@]}" --simulate "$work/data.csv" --quiet
    make layers estimate "$work/data.csv" "${layers[@]}" --truth "$work/data.csv.json" --samples 300 --warmup 200 --out "$work/layers"
    PYTHONPATH=$here/../broken /usr/bin/python3 -c "import capture, sys; capture.prepare(sys.argv[1])" "$work"
    make capture capture --views "$work/views.json" --resolution 16 --iterations 100 --hold-out 1 --out "$work/capture"
    unit_tests=$(dirname "$subject")/../../tests/lacquer_tests
    if [ -x "$unit_tests" ]; then
        LACQUER_REPORT_PAGES=$work "$unit_tests" --gtest_filter=EstimateReport.IsOneFileInItsFolder >"$work/pages.log" 2>&1 ||
            { cat "$work/pages.log"; echo "0 passed, 1 failed"; exit 1; }
        reports+=("$work"/estimate-*/report.html)
    fi
fi

checks_of() { echo "$work/$(basename "$(dirname "$1")").checks"; }
# check REPORT: what its check prints, into a file of its own. A browser waits more than it works, so that several run at a time.
check() {
    local report=$1 check=check_report.mjs folder=$screenshots
    grep -q '"schema":"lacquer-bulk-report' "$report" && check=check_bulk_report.mjs
    grep -q '"schema":"lacquer-estimate-report' "$report" && check=check_estimate_report.mjs
    grep -q '"schema":"lacquer-capture-report' "$report" && check=check_capture_report.mjs
    [ "$count" -gt 1 ] && folder=$screenshots/$(basename "$(dirname "$report")")
    node "$here/$check" "$report" "$folder" >"$(checks_of "$report")"
}
export -f check checks_of
export here work screenshots count=${#reports[@]}
printf '%s\0' "${reports[@]}" | xargs -0 -P "$(($(nproc) + 1))" -I{} bash -c 'check "$1"' check {}

passed=0 failed=0
for report in "${reports[@]}"; do
    output=$(cat "$(checks_of "$report")")
    echo "$output"
    passed=$((passed + $(grep -c '^ok ' <<<"$output")))
    fails=$(grep -c '^FAIL' <<<"$output")
    # A check that ends without its last line has failed, too.
    tail -n 1 <<<"$output" | grep -q '^[0-9]* passed' || fails=$((fails + 1))
    failed=$((failed + fails))
done
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
