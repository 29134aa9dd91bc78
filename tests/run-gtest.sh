#!/usr/bin/env bash
# Runs a GoogleTest executable, its tests divided among the cores, and closes with "N passed, N failed, N skipped".
# usage: run-gtest.sh EXECUTABLE [GoogleTest options]
set -u
logs=$(mktemp -d); trap 'rm -rf "$logs"' EXIT
shards=$(nproc) pids=() status=0
for ((i = 0; i < shards; i++)); do
    GTEST_TOTAL_SHARDS=$shards GTEST_SHARD_INDEX=$i "$@" --gtest_brief=1 >"$logs/$i" 2>&1 &
    pids+=($!)
done
passed=0 failed=0 skipped=0
for ((i = 0; i < shards; i++)); do
    wait "${pids[i]}"; s=$?
    cat "$logs/$i"
    # "[==========] 12 tests from 3 test suites ran." tells the total; what neither passed nor was skipped has failed.
    t=$(sed -nE 's/^\[=+\] ([0-9]+) tests? from .* ran.*/\1/p' "$logs/$i" | tail -n 1)
    p=$(sed -nE 's/^\[ *PASSED *\] ([0-9]+) tests?.*/\1/p' "$logs/$i" | tail -n 1)
    k=$(sed -nE 's/^\[ *SKIPPED *\] ([0-9]+) tests?.*/\1/p' "$logs/$i" | tail -n 1)
    f=$((${t:-0} - ${p:-0} - ${k:-0}))
    [ $s -ne 0 ] && [ "$f" -le 0 ] && f=1  # it crashed
    [ $s -ne 0 ] && status=$s
    passed=$((passed + ${p:-0})) failed=$((failed + f)) skipped=$((skipped + ${k:-0}))
done
echo "$passed passed, $failed failed, $skipped skipped"
exit $status
