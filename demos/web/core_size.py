"""Sizes of modules that have the core but no Bullet. usage: core_size.py LIBPLIANT LIBCCD PROGRAM OUT

Programs of demos/ as they are, which link what they call; the core of the gallery: what its scenes call in 300 frames, set
as the page opens them, and what its mouse calls; and the whole core, every function of the headers shown. Prints bytes of
WebAssembly, uncompressed and compressed by gzip. All but the last have to stay within 400,000 bytes."""

import gzip
import json
import re
import subprocess
import sys
from pathlib import Path

from called_functions import called_functions

most_bytes, frames = 400_000, 300
library, ccd, program, out = (Path(path).resolve() for path in sys.argv[1:])
root = Path(__file__).resolve().parents[2]
options = ["-Oz", "-msimd128", "-sENVIRONMENT=node", "-sALLOW_MEMORY_GROWTH=1", "-sMALLOC=emmalloc",
           "-Wl,-mllvm,-no-stack-coloring"]


def link(name, *inputs):
    module = out / f"{name}.js"
    subprocess.run(["emcc", *options, "-I", root / "core/include", *inputs, library, ccd, "-o", module], check=True)
    code = module.with_suffix(".wasm").read_bytes()
    print(f"{name}: {len(code)} bytes, {len(gzip.compress(code, 9))} compressed", flush=True)
    return len(code)


def link_functions(title, names):
    listing = out / f"functions_{title}"
    listing.write_text("".join(f"_{name}\n" for name in [*sorted(names), "malloc", "free"]))
    return link(f"{title}_{len(names)}_functions", "--no-entry", f"-sEXPORTED_FUNCTIONS=@{listing}")


def shown_functions():
    symbols = subprocess.run(["llvm-nm-14", "--defined-only", "--extern-only", library], check=True, text=True,
                             capture_output=True).stdout
    return set(re.findall(r" T (pli_\w+)$", symbols, re.M))


def gallery_functions(shown):
    """What all scenes call, and the mouse: pulls, cuts, shots, and what is shown of contacts and clusters."""
    scenes = json.loads(subprocess.run([program, "list", "--json"], check=True, text=True, capture_output=True).stdout)
    called = {"pli_body_cut_swept"}
    called.update(re.findall(r"\bpli_\w+", (root / "demos/engines/pliant_interaction.cpp").read_text()))
    for scene in scenes["scenes"]:
        called |= called_functions(shown, program, "run", scene["name"], "--frames", str(frames), "--json")
    return called & shown


def main():
    out.mkdir(parents=True, exist_ok=True)
    sizes = [link(name, root / f"demos/{name}/main.c") for name in ("hello_core", "hello_features", "hello_kinds")]
    shown = shown_functions()
    sizes.append(link_functions("gallery", gallery_functions(shown)))
    link_functions("all", shown)
    if max(sizes) > most_bytes: sys.exit(f"a module of the core has more than {most_bytes} bytes")


main()
