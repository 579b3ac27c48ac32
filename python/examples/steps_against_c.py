"""What calling from Python costs: 1,000 steps of a sheet of 64 x 64 nodes, called one by one from Python, and by a loop
in C, in turn; time of this thread, in which other work on the machine does not count.

usage: steps_against_c.py COMPILER
"""

import ctypes
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pliant
from pliant._library import ffi

LOOP = """
int run_steps(int (*step)(void*, float), void* world, int count) {
    for (int i = 0; i < count; ++i) {
        if (step(world, 1.0f / 60.0f) != 0) { return 1; }
    }
    return 0;
}
"""


def make_world():
    context = pliant.Context()
    world = pliant.World(context)
    mesh = pliant.Mesh.create_patch(
        context, corner_00=(-1, 0, -1), corner_10=(1, 0, -1), corner_01=(-1, 0, 1), corner_11=(1, 0, 1), columns=64,
        rows=64, pins=15, diagonals=True)
    mesh.set_total_mass(1.0)
    pliant.Body.create(world, mesh, solver={"position_iterations": 10}).enable_colored_links()
    return world


def time_python():
    world = make_world()
    start = time.thread_time()
    for _ in range(1000):
        world.step(1 / 60)
    return time.thread_time() - start


def time_c(loop):
    world = make_world()
    step = int(ffi.cast("uintptr_t", ffi.addressof(pliant.lib, "pli_world_step")))
    pointer = int(ffi.cast("uintptr_t", world.pointer))
    start = time.thread_time()
    assert loop(ctypes.c_void_p(step), ctypes.c_void_p(pointer), 1000) == 0
    return time.thread_time() - start


with tempfile.TemporaryDirectory() as folder:
    source, library = Path(folder) / "loop.c", Path(folder) / "loop.so"
    source.write_text(LOOP)
    subprocess.run([sys.argv[1], "-O2", "-shared", "-fPIC", "-o", library, source], check=True)
    loop = ctypes.CDLL(str(library)).run_steps
    pairs = [(time_python(), time_c(loop)) for _ in range(7)]
python_ms, c_ms = (statistics.median(times) * 1e3 for times in zip(*pairs))
ratio = statistics.median(a / b for a, b in pairs)
print(f"1,000 steps from Python {python_ms:.0f} ms, from C {c_ms:.0f} ms; median of the ratios {ratio:.3f}")
