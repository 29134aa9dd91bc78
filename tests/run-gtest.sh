#!/usr/bin/env bash
# Runs a GoogleTest executable, its tests divided among the cores, names those that took above ten seconds, and closes with
# "N passed, N failed, N skipped".
# usage: run-gtest.sh EXECUTABLE [GoogleTest options]
set -u
export logs; logs=$(mktemp -d); trap 'rm -rf "$logs"' EXIT
# Several times as many parts as cores: some tests take a minute, and no core should wait for another one's.
export GTEST_TOTAL_SHARDS=$((8 * $(nproc)))
seq 0 $((GTEST_TOTAL_SHARDS - 1)) | xargs -P "$(nproc)" -I{} bash -c \
    'GTEST_SHARD_INDEX={} "$@" --gtest_brief=1 --gtest_output="xml:$logs/{}.xml" >"$logs/{}" 2>&1; echo $? >"$logs/{}.status"' run "$@"
passed=0 failed=0 skipped=0 status=0 failures=()
for ((i = 0; i < GTEST_TOTAL_SHARDS; i++)); do
    s=$(cat "$logs/$i.status" 2>/dev/null || echo 1)
    if [ "$s" -eq 0 ]; then cat "$logs/$i"; else failures+=("$logs/$i"); fi
    # "[==========] 12 tests from 3 test suites ran." tells the total; what neither passed nor was skipped has failed.
    t=$(sed -nE 's/^\[=+\] ([0-9]+) tests? from .* ran.*/\1/p' "$logs/$i" | tail -n 1)
    p=$(sed -nE 's/^\[ *PASSED *\] ([0-9]+) tests?.*/\1/p' "$logs/$i" | tail -n 1)
    k=$(sed -nE 's/^\[ *SKIPPED *\] ([0-9]+) tests?.*/\1/p' "$logs/$i" | tail -n 1)
    f=$((${t:-0} - ${p:-0} - ${k:-0}))
    [ "$s" -ne 0 ] && [ "$f" -le 0 ] && f=1  # it crashed
    [ "$s" -ne 0 ] && status=$s
    passed=$((passed + ${p:-0})) failed=$((failed + f)) skipped=$((skipped + ${k:-0}))
done
for log in "${failures[@]}"; do cat "$log"; done  # last, where they are looked for
cat "$logs"/*.xml 2>/dev/null | sed -nE 's/.*<testcase name="([^"]*)".* time="([0-9]{2,}\.?[0-9]*)".* classname="([^"]*)".*/slow  \2 s  \3.\1/p' |
    sort -k2 -rn | head -n 40
echo "$passed passed, $failed failed, $skipped skipped"
exit "$status"
