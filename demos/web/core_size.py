"""Sizes of modules that have the core but no Bullet. usage: core_size.py LIBPLIANT LIBCCD OUT

Programs of demos/ as they are, which link what they call, and the whole core: every function of the headers shown. Prints
bytes of WebAssembly, uncompressed and compressed by gzip, and which rooms of the core they are made of."""

import gzip
import os
import re
import subprocess
import sys
from pathlib import Path

library, ccd, out = (Path(path).resolve() for path in sys.argv[1:])
root = Path(__file__).resolve().parents[2]
options = ["-Oz", "-msimd128", "-sENVIRONMENT=node", "-sALLOW_MEMORY_GROWTH=1", "-sMALLOC=emmalloc",
           "-Wl,-mllvm,-no-stack-coloring"]


def link(name, *inputs):
    module = out / f"{name}.js"
    subprocess.run(["emcc", *options, "-I", root / "core/include", *inputs, library, ccd, "-o", module], check=True)
    code = module.with_suffix(".wasm").read_bytes()
    print(f"{name}: {len(code)} bytes, {len(gzip.compress(code, 9))} compressed")
    return len(code)


def shown_functions():
    symbols = subprocess.run(["llvm-nm-14", "--defined-only", "--extern-only", library], check=True, text=True,
                             capture_output=True).stdout
    return sorted(set(re.findall(r" T (pli_\w+)$", symbols, re.M)))


def main():
    out.mkdir(parents=True, exist_ok=True)
    sizes = {name: link(name, root / f"demos/{name}/main.c") for name in ("hello_core", "hello_kinds", "hello_features")}
    names = shown_functions()
    listing = out / "functions"
    listing.write_text("".join(f"_{name}\n" for name in [*names, "malloc", "free"]))
    link(f"all {len(names)} functions".replace(" ", "_"), "--no-entry", f"-sEXPORTED_FUNCTIONS=@{listing}")
    return 0 if max(sizes.values()) <= 400000 else 1


sys.exit(main())
