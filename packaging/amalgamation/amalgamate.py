#!/usr/bin/env python3
"""Makes pliant.c and pliant.h out of the sources of the core.

    amalgamate.py ROOT OUT

Headers come first, each once, then the sources in the order of core/CMakeLists.txt. A name at file scope that is local
to several sources gets the name of its source in front. Kernels that the library compiles for AVX2 and AVX-512 come last,
with a suffix on all of their names, between pragmas that select the instruction set.
"""

import pathlib
import re
import sys

# Rooms of the core that a program can leave out, by the switch that leaves them out.
SWITCHES = {
    "src/cluster/": "PLIANT_FEATURES_CLUSTERS",
    "src/cut/": "PLIANT_FEATURES_CUT",
    "src/file/": "PLIANT_FEATURES_FILES",  # names all features: not there when one of them is not
    "src/self_collision/": "PLIANT_FEATURES_SELF_COLLISION",
    "src/solver/implicit/": "PLIANT_FEATURES_IMPLICIT",
    "src/solver/xpbd/": "PLIANT_FEATURES_XPBD",
    "src/base/threads.c": "PLIANT_FEATURES_THREADS",
    "src/geometry/convex_penetration.c": "PLIANT_WITH_CCD",
}

# What tells headers of vectors the instruction set, and the sets that a part of the file is for.
SETS = {"avx2": "defined(__AVX2__)", "avx512": "defined(PLII_WIDE_OF_SIXTEEN)"}
VECTORS = ("src/math/simd_float8.h", "src/math/simd_wide.h")

INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"\s*$', re.M)
WORD = re.compile(r"\b[A-Za-z_]\w*\b")
# What is not code; a name in it stays.
QUOTED = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)
STATIC = re.compile(
    r"^(?:static|PLII_SIMD_INLINE|PLII_SIMD_LARGE)\b[^;{}()=]*?\b(\w+)\s*(?:\(|=|\[|;)", re.M
)
TAG = re.compile(r"^(?:typedef\s+)?(?:struct|enum|union)\s+(\w+)\s*\{", re.M)
ENUMERATION = re.compile(r"^(?:typedef\s+)?enum(?:\s+\w+)?\s*\{([^}]*)\}", re.M)
TYPEDEF = re.compile(r"^(?:typedef\b[^;{]*?|\})\s*(\w+)(?:\s+__attribute__[^;]*)?;", re.M)
MACRO = re.compile(r"^\s*#\s*define\s+(\w+)", re.M)


def code_of(text):
    return QUOTED.sub(lambda m: " " if m[0][0] == "/" else '""', text)


def local_names(text):
    """Names that a source declares at file scope for itself."""
    code = code_of(text)
    names = set(STATIC.findall(code)) | set(TAG.findall(code)) | set(TYPEDEF.findall(code)) | set(MACRO.findall(code))
    for body in ENUMERATION.findall(code):
        names |= {part.split("=")[0].strip() for part in body.split(",")}
    made = re.findall(r"^[A-Z_]+\((\w+)(?:, \w+)*\)$", code, re.M)  # functions that a macro makes
    return (names | set(made)) - {""}


def rename(text, new_names):
    def rename_words(piece):
        return WORD.sub(lambda m: new_names.get(m[0], m[0]), piece)

    parts, last = [], 0
    for quoted in QUOTED.finditer(text):
        parts += [rename_words(text[last : quoted.start()]), quoted[0]]
        last = quoted.end()
    return "".join(parts + [rename_words(text[last:])])


class Sources:
    """A library: its public headers in include/, the rest in src/."""

    def __init__(self, folder):
        self.folder = folder

    def find(self, name):
        for folder in ("include", "src"):
            path = self.folder / folder / name
            if path.exists():
                return path
        sys.exit(f'amalgamate.py: "{name}" is neither in {self.folder}/include nor in {self.folder}/src')

    def expand(self, path, once):
        """The text of a file with those that it includes and `once` does not have yet in it."""

        def include(match):
            name = match[1]
            found = path.parent / name
            found = found if found.exists() else self.find(name)
            if found in once:
                return ""
            once.append(found)
            return self.expand(found, once)

        text = path.read_text().replace("#pragma once\n", "")
        return INCLUDE.sub(include, text)


def public_header(core):
    once = []
    text = core.expand(core.folder / "include/pliant/pliant.h", once)
    for path in sorted((core.folder / "include/pliant").glob("*.h")):
        if path not in once and path.name != "pliant.h":
            once.append(path)
            text += core.expand(path, once)
    # Its own includes of <pliant/...> are all here.
    return re.sub(r"^\s*#\s*include\s+<pliant/[^>]+>\s*$", "", text, flags=re.M), once


def switch_of(name):
    found = [switch for part, switch in SWITCHES.items() if name.startswith(part)]
    return found[0] if found else None


def listed_sources(folder, ending):
    text = (folder / "CMakeLists.txt").read_text()
    names = list(dict.fromkeys(re.findall(rf"\bsrc/[\w/]+\.{ending}\b", text)))
    present = {str(p.relative_to(folder)) for p in (folder / "src").rglob(f"*.{ending}")}
    if set(names) != present:
        sys.exit(f"amalgamate.py: {folder}/CMakeLists.txt and its sources differ in {set(names) ^ present}")
    return names


def resolve(texts):
    """Puts the name of the source in front of names that several sources have; fails when that is no new name."""
    owners = {}
    for name, text in texts.items():
        for local in local_names(text):
            owners.setdefault(local, []).append(name)
    for name, text in texts.items():
        is_kernel = name.endswith("_base.c")  # there macros make names out of names
        shared = {local for local in local_names(text) if is_kernel or len(owners[local]) > 1}
        stem = pathlib.Path(name).stem
        new_names = {local: f"{stem}_{local}" for local in shared}
        taken = [new for new in new_names.values() if new in owners]
        if taken:
            sys.exit(f"amalgamate.py: {name}: the new name {taken[0]} is taken")
        texts[name] = rename(text, new_names)


def with_sets(text, last):
    """The text for processors that have the sets up to `last`, or none."""
    has = last is not None
    for instructions, condition in SETS.items():
        text = text.replace(condition, "1" if has else "0")
        has = has and instructions != last
    return text


def wide_kernels(core, names, instructions, once, gated):
    """The kernels of an instruction set, behind the headers of vectors for it."""
    text = "".join((core.folder / name).read_text().replace("#pragma once\n", "") for name in VECTORS)
    text = "#undef PLII_SIMD_LARGE\n" + INCLUDE.sub("", with_sets(text, instructions))
    suffixed = {n: f"{n}_{instructions}" for n in local_names(text) if not n.startswith("PLII_SIMD")}
    suffixed.update({f"plii_float8_{n}": f"plii_float8_{n}_{instructions}" for n in
                     re.findall(r"PLII_FLOAT8_(?:UNARY|BINARY)\(([a-z]\w*),", text)})
    result = f"\n#if PLIANT_SIMD_X86\nPLII_{instructions.upper()}_BEGIN\n"
    result += rename(text.replace("plii_float8_##name", f"plii_float8_##name##_{instructions}"), suffixed)
    for name in (n for n in names if n.endswith(f"_{instructions}.c")):
        kernel = core.expand(core.folder / name, list(once))
        own = {n: f"{pathlib.Path(name).stem}_{n}" for n in local_names(kernel)}
        result += gated(name, rename(kernel, {**suffixed, **own}))
    return result + f"\nPLII_{instructions.upper()}_END\n#endif\n"


HEAD = """/* Pliant, soft-body dynamics, in one file. Made of core/ by packaging/amalgamation/amalgamate.py; see docs/building.md. */
"""


def main():
    root, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    core = Sources(root / "core")
    header, once = public_header(core)
    names = listed_sources(root / "core", "c")
    plain = [n for n in names if not n.endswith(tuple(f"_{instructions}.c" for instructions in SETS))]
    texts, headers = {}, ""
    for name in plain:  # headers first: none may lie inside of a switch
        for included in INCLUDE.findall((core.folder / name).read_text()):
            beside = (core.folder / name).parent / included
            path = beside if beside.exists() else core.find(included)
            if path not in once:
                once.append(path)
                headers += core.expand(path, once)
    for name in plain:
        texts[name] = core.expand(core.folder / name, once)
    resolve(texts)

    files = SWITCHES["src/file/"]
    features = " && ".join(each for folder, each in SWITCHES.items() if folder[-1] == "/" and each != files)
    defaults = {each: "1" for each in SWITCHES.values() if each != files}
    defaults |= {"PLIANT_WITH_CCD": "0", files: f"({features})"}
    switches = "".join(f"#ifndef {each}\n#define {each} {value}\n#endif\n" for each, value in defaults.items())
    switches += f'#if {files} && !({features})\n#error "{files} needs all features but threads"\n#endif\n'
    result = HEAD + (root / "packaging/amalgamation/head.inc").read_text() + switches
    result += '#include "pliant.h"\n' + with_sets(headers, None)

    def gated(name, text):
        switch = switch_of(name)
        return f"\n/* {name} */\n" + (f"#if {switch}\n{text}\n#endif\n" if switch else text)

    for name in plain:
        result += gated(name, texts[name])
    for instructions in SETS:
        result += wide_kernels(core, names, instructions, once, gated)
    out.mkdir(parents=True, exist_ok=True)
    (out / "pliant.h").write_text(HEAD + header)
    (out / "pliant.c").write_text(result)


if __name__ == "__main__":
    main()
