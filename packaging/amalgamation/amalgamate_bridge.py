#!/usr/bin/env python3
"""Makes pliant_bullet.cpp and pliant_bullet.h, which go with pliant.h, out of the sources of the bridge to Bullet.

    amalgamate_bridge.py ROOT OUT

Names in the unnamed namespaces of its sources differ from each other, so they stand as they are.
"""

import pathlib
import re
import sys

from amalgamate import INCLUDE, Sources, listed_sources

HEAD = """/* Pliant's bridge to Bullet, in one file. Made of bullet_bridge/ by packaging/amalgamation/amalgamate_bridge.py; see
   docs/building.md. */
"""


def expand_headers(library, text, folder, once):
    """The text without its own includes, and those headers that `once` does not have yet in front of it."""
    before = ""
    for name in INCLUDE.findall(text):
        beside = folder / name
        path = beside if beside.exists() else library.find(name)
        if path not in once:
            once.append(path)
            before += expand_headers(library, path.read_text(), path.parent, once)
    return before + INCLUDE.sub("", text)


def main():
    root, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    bridge = Sources(root / "bullet_bridge")
    once, header, source = [], "", ""
    for path in sorted((bridge.folder / "include/pliant_bullet").glob("*.h")):
        if path not in once:
            once.append(path)
            header += expand_headers(bridge, path.read_text(), path.parent, once)
    for name in listed_sources(bridge.folder, "cpp"):
        path = bridge.folder / name
        source += f"\n// {name}\n" + expand_headers(bridge, path.read_text(), path.parent, once)
    foreign = re.compile(r"^#include <pliant(?:_bullet)?/[^>]+>\n", re.M)  # all of them are in the two headers
    out.mkdir(parents=True, exist_ok=True)
    (out / "pliant_bullet.h").write_text(HEAD + '#include "pliant.h"\n' + foreign.sub("", header))
    (out / "pliant_bullet.cpp").write_text(HEAD + '#include "pliant_bullet.h"\n' + foreign.sub("", source))


main()
