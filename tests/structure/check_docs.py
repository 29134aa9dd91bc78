#!/usr/bin/env python3
"""Checks that the prose of the documents is wrapped at one width: docs/*.md, README.md, CONTRIBUTING.md.

usage: check_docs.py [--fix]
Headings, tables, code blocks, images, formulas (indented lines) and the structure of lists stay as they are; paragraphs
and the text of list items are filled to WIDTH columns. --fix wraps them. Prints each document that is not wrapped and a
closing line 'N passed, N failed'. The check is itself checked: a paragraph with one line too long or one broken too
early must be found, in every document, and what is no prose must stay.
"""
import os
import re
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
WIDTH = 120
# Made by the program.
GENERATED = {"plugins.md"}
MARKER = re.compile(r"^(\s*)([-*+]|\d+\.)\s+")


def keeps_line(line):
    """Lines that are no prose: blank ones, headings, tables, quotes, rules, HTML, indented formulas."""
    return (not line.strip() or line.startswith(("#", "|", ">", "    ", "<", "![")) or
            re.match(r"^ {2,3}\S", line) and not MARKER.match(line) or re.match(r"^([-*_]\s*){3,}$", line.strip()))


def words_of(text):
    """Words that may not be parted: what stands between backticks and in links stays on a line."""
    text = re.sub(r"\s+", " ", text.strip())
    protected = re.sub(r"`[^`]*`|\]\([^)]*\)", lambda m: m.group(0).replace(" ", "\0"), text)
    return [w.replace("\0", " ") for w in protected.split(" ") if w]


def begins_block(word):
    """True for words that would mean something else at the start of a line."""
    return bool(re.match(r"^([-+*]|#+|\d+[.)]|>|\||=+|-+)$", word)) or word.startswith("|")


def fill(text, first, rest):
    lines, current = [], first
    empty = True
    words = words_of(text)
    for i, word in enumerate(words):
        if not empty and len(current) + 1 + len(word) > WIDTH and not begins_block(word):
            lines.append(current)
            current, empty = rest, True
        current += word if empty else " " + word
        empty = False
    return lines + [current] if words else lines


def wrap(text):
    out, block, first, rest, fenced = [], [], "", "", False

    def flush():
        if block:
            out.extend(fill(" ".join(block), first, rest))
            block.clear()

    for line in text.split("\n"):
        if line.lstrip().startswith("```"):
            flush()
            fenced = not fenced
            out.append(line)
            continue
        if fenced:
            out.append(line)
            continue
        item = MARKER.match(line)
        if item:
            flush()
            first, rest = line[:item.end()].rstrip() + " ", " " * item.end()
            block.append(line[item.end():])
        elif block and rest and line.startswith(rest) and line.strip() and not line.startswith(rest + "  "):
            block.append(line)  # the item goes on
        elif keeps_line(line):
            flush()
            first = rest = ""
            out.append(line)
        else:
            if not block:
                first = rest = ""
            elif rest and not line.startswith(" "):
                pass  # a lazy continuation of the item
            block.append(line)
            if line.endswith("  ") or line.endswith("\\"):
                flush()
                first = rest = ""
    flush()
    return "\n".join(out)


def documents():
    folder = os.path.join(ROOT, "docs")
    names = [os.path.join("docs", n) for n in sorted(os.listdir(folder)) if n.endswith(".md") and n not in GENERATED]
    return names + ["README.md", "CONTRIBUTING.md"]


# What is no prose, and would be damaged as prose.
UNTOUCHED = [
    "# A heading\n",
    "| a | b |\n|---|---|\n| " + "long " * 40 + "| c |\n",
    "```\ncode  " + "x " * 100 + "\n```\n",
    "  f(x) = " + "y + " * 40 + "z\n",
    "- one\n- two\n  - three\n\n1. four\n2. five\n",
    "![" + "an image of " * 15 + "](images/x.png)\n",
]


def controls(text):
    """The document with two lines of a paragraph joined, and with one line broken, where it has such a paragraph."""
    lines = text.split("\n")
    fenced = False
    for i in range(len(lines) - 1):
        fenced ^= lines[i].lstrip().startswith("```")
        if fenced or len(lines[i]) < WIDTH * 0.8 or keeps_line(lines[i]) or not lines[i + 1] or keeps_line(lines[i + 1]):
            continue
        if MARKER.match(lines[i]) or MARKER.match(lines[i + 1]):
            continue
        yield "\n".join(lines[:i] + [lines[i] + " " + lines[i + 1].strip()] + lines[i + 2:])
        yield "\n".join(lines[:i] + lines[i].split(" ", 1) + lines[i + 1:])
        return


def main():
    passed = failed = 0
    for text in UNTOUCHED:
        if wrap(text) == text:
            passed += 1
        else:
            failed += 1
            print(f"is no prose, but would be wrapped: {text[:40]!r}")
    for name in documents():
        path = os.path.join(ROOT, name)
        with open(path, encoding="utf-8") as file:
            text = file.read()
        wrapped = wrap(text)
        if wrapped != text and "--fix" in sys.argv:
            with open(path, "w", encoding="utf-8") as file:
                file.write(wrapped)
            text = wrapped
        if wrapped != text:
            line = next(i for i, (a, b) in enumerate(zip(text.split("\n") + [None], wrapped.split("\n") + [None])) if a != b)
            print(f"{name}:{line + 1}: is not wrapped at {WIDTH} columns; tests/structure/check_docs.py --fix")
        missed = [c for c in controls(wrapped) if wrap(c) == c]
        if missed:
            print(f"{name}: negative control not found")
        failed += wrapped != text or bool(missed)
        passed += wrapped == text and not missed
    print(f"{passed} passed, {failed} failed")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
