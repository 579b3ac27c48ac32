"""Which functions of the core a program calls, told by gdb: each stops the program the first time."""

import re
import subprocess
import tempfile

# Functions that the program does not link stay pending.
settings = ["set breakpoint pending on", "set debuginfod enabled off", "set confirm off", "set auto-solib-add off"]


def called_functions(names, *command):
    """Those of `names` that the command calls, one of a program with symbols."""
    with tempfile.NamedTemporaryFile("w", suffix=".gdb") as script:
        # After the end of the program `continue` is an error, which ends gdb.
        script.write("\n".join([*settings, *(f"tbreak {name}" for name in names), "run", *["continue"] * len(names), ""]))
        script.flush()
        run = subprocess.run(["gdb", "-nx", "-batch", "-x", script.name, "--args", *command], text=True,
                             capture_output=True, check=False)
    if "exited normally" not in run.stdout:
        raise RuntimeError(f"{' '.join(map(str, command))}: {run.stdout[-500:]} {run.stderr[-500:]}")
    return set(re.findall(r" (?:in )?(pli_\w+) \(", run.stdout)) & set(names)
