"""The C library, and what its headers declare, which is beside this file."""

import re
from pathlib import Path

from cffi import FFI

_here = Path(__file__).parent
declarations = (_here / "declarations.h").read_text()

ffi = FFI()
ffi.cdef(declarations)
lib = ffi.dlopen(str(_here / "libpliant.so"))

constants = {
    name: float(value) if re.search("[.e]", value) else int(value)
    for name, value in re.findall(r"^// constant PLI_(\w+) (\S+)$", declarations, re.M)
}
functions = re.findall(r"\b(pli_\w+)\(", re.sub(r"\(\*\w+\)\(", "", declarations))
functions = [name for name in dict.fromkeys(functions) if hasattr(lib, name)]
