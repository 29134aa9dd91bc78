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
said=$(printf '%s\n' "${files[@]}" | xargs -P "$(nproc)" -n 32 "$format" --dry-run -Werror 2>&1)
mapfile -t crooked < <(sed -nE 's/^([^ :]+):[0-9]+:.*/\1/p' <<<"$said" | sort -u)
# A header that it takes for another language is not looked at, and not named.
if grep "not support" <<<"$said"; then failed=$((failed + 1)); fi
for file in "${crooked[@]}"; do echo "$file: run clang-format -i on it"; done
failed=$((failed + ${#crooked[@]}))
echo "$((${#files[@]} - ${#crooked[@]})) passed, $failed failed"
exit $((failed > 0))
