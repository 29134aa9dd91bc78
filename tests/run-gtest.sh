#!/usr/bin/env bash
# Runs a GoogleTest executable and closes with "N passed, N failed, N skipped".
# usage: run-gtest.sh EXECUTABLE [GoogleTest options]
set -u
log=$(mktemp); trap 'rm -f "$log"' EXIT
"$@" --gtest_brief=1 >"$log" 2>&1; status=$?
cat "$log"
count() { sed -nE "s/^\[ *$1 *\] ([0-9]+) tests?.*/\1/p" "$log" | head -n 1; }
passed=$(count PASSED); failed=$(count FAILED); skipped=$(count SKIPPED)
[ $status -ne 0 ] && [ -z "$failed" ] && failed=1  # it crashed
echo "${passed:-0} passed, ${failed:-0} failed, ${skipped:-0} skipped"
exit $status
