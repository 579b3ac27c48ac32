"""The C library, and what its headers declare, which is beside this file."""

import re
from pathlib import Path

from cffi import FFI

_here = Path(__file__).parent
declarations = (_here / "declarations.h").read_text()

ffi = FFI()
ffi.cdef(declarations)
_name = re.match(r"// library (\S+)\n", declarations)[1]
# Beside this file, or else where the system has its libraries.
lib = ffi.dlopen(str(_here / _name) if (_here / _name).exists() else _name)

constants = {
    name: float(value) if re.search("[.e]", value) else int(value)
    for name, value in re.findall(r"^// constant PLI_(\w+) (\S+)$", declarations, re.M)
}
functions = re.findall(r"\b(pli_\w+)\(", re.sub(r"\(\*\w+\)\(", "", declarations))
functions = [name for name in dict.fromkeys(functions) if hasattr(lib, name)]
