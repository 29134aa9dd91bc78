#!/usr/bin/env bash
# Every C++ file is as clang-format (14, .clang-format) leaves it. The check is itself checked: a crooked file must be found.
# usage: check_format.sh
set -u
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
format=$(command -v clang-format-14 || command -v clang-format)
failed=0
if printf 'int  F( ){return 1 ;}\n' | "$format" --dry-run -Werror --assume-filename=src/x.cpp 2>/dev/null; then
    echo "negative control not found: a crooked line"
    failed=1
fi
mapfile -t files < <(find src tests bench -name '*.h' -o -name '*.cpp' | sort)
mapfile -t crooked < <(printf '%s\n' "${files[@]}" | xargs -P "$(nproc)" -n 32 "$format" --dry-run -Werror 2>&1 |
    sed -nE 's/^([^ :]+):[0-9]+:.*/\1/p' | sort -u)
for file in "${crooked[@]}"; do echo "$file: run clang-format -i on it"; done
failed=$((failed + ${#crooked[@]}))
echo "$((${#files[@]} - ${#crooked[@]})) passed, $failed failed"
exit $((failed > 0))
