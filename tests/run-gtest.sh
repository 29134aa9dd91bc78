#!/usr/bin/env bash
# Runs a GoogleTest executable and closes with "N passed, N failed, N skipped".
# usage: run-gtest.sh EXECUTABLE [GoogleTest options]
set -u
log=$(mktemp); trap 'rm -f "$log"' EXIT
"$@" --gtest_brief=1 >"$log" 2>&1; status=$?
cat "$log"
# "[==========] 12 tests from 3 test suites ran." tells the total; what neither passed nor was skipped has failed.
total=$(sed -nE 's/^\[=+\] ([0-9]+) tests? from .* ran.*/\1/p' "$log" | tail -n 1)
passed=$(sed -nE 's/^\[ *PASSED *\] ([0-9]+) tests?.*/\1/p' "$log" | tail -n 1)
skipped=$(sed -nE 's/^\[ *SKIPPED *\] ([0-9]+) tests?.*/\1/p' "$log" | tail -n 1)
failed=$(( ${total:-0} - ${passed:-0} - ${skipped:-0} ))
[ $status -ne 0 ] && [ "$failed" -le 0 ] && failed=1  # it crashed
echo "${passed:-0} passed, $failed failed, ${skipped:-0} skipped"
exit $status
