"""Writes what cffi has to know of the C interface: the library's name, types and functions as the headers declare them,
and constants.

usage: declarations.py COMPILER INCLUDE_FOLDER LIBRARY OUTPUT
"""

import re
import subprocess
import sys
from pathlib import Path


def preprocess(compiler, include):
    command = [compiler, "-E", "-D__attribute__(x)=", "-I", str(include), "-"]
    text = subprocess.run(command, input="#include <pliant/pliant.h>\n", capture_output=True, text=True, check=True)
    lines, is_ours = [], False
    for line in text.stdout.splitlines():
        marker = re.match(r'# \d+ "([^"]*)"', line)
        if marker:
            is_ours = "/pliant/" in marker[1]
        elif is_ours:
            lines.append(line)
    return "\n".join(lines)


def without_bodies(text):
    """Inline functions are not in the library."""
    kept, at = [], 0
    for start in re.finditer(r"static inline", text):
        if start.start() < at:
            continue
        kept.append(text[at : start.start()])
        at = text.index("{", start.start())
        depth = 0
        while True:
            depth += {"{": 1, "}": -1}.get(text[at], 0)
            at += 1
            if depth == 0:
                break
    return "".join(kept) + text[at:]


def declarations(compiler, include):
    text = without_bodies(preprocess(compiler, include))
    text = re.sub(r"_Static_assert\s*\(.*?\);", "", text, flags=re.S)
    text = re.sub(r"\b_Bool\b", "bool", text)
    constants = []
    for header in sorted((include / "pliant").glob("*.h")):
        constants += re.findall(r"^#define (PLI_[A-Z0-9_]+) (\(?-?[0-9][0-9.e+-]*f?\)?)$", header.read_text(), re.M)
    numbers = "".join(f"// constant {name} {value.strip('()').rstrip('f')}\n" for name, value in constants)
    return numbers + re.sub(r"\n\s*\n+", "\n", text)


if __name__ == "__main__":
    compiler, include, library, output = sys.argv[1:]
    Path(output).write_text(f"// library {library}\n" + declarations(compiler, Path(include)))
