"""Error against run time of the solvers: a cloth swings down from one edge for half a second, and is compared with the
same cloth under many more steps of the same solver.

usage: error_against_time.py PICTURE
"""

import sys
import time

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import pliant

SIDE = 15


def make_cloth(solver, iterations):
    context = pliant.Context()
    world = pliant.World(context)
    mesh = pliant.Mesh.create_patch(
        context, corner_00=(0, 0, 0), corner_10=(1, 0, 0), corner_01=(0, 0, 1), corner_11=(1, 0, 1), columns=SIDE,
        rows=SIDE, diagonals=True)
    mesh.set_total_mass(0.2)
    cloth = pliant.Body.create(world, mesh, solver={"position_iterations": iterations})
    for node in range(SIDE):
        cloth.set_node_mass(node, 0.0)
    if solver == "XPBD":
        cloth.enable_xpbd(substeps=iterations)
        cloth.enable_xpbd_links()
    elif solver == "implicit":
        cloth.enable_implicit(method="conjugate_gradient")
    else:
        cloth.enable_colored_links()
    return world, cloth


def swing(solver, steps_per_second, iterations):
    world, cloth = make_cloth(solver, iterations)
    start = time.perf_counter()
    for _ in range(steps_per_second // 2):
        world.step(1 / steps_per_second)
    return cloth.positions.copy(), time.perf_counter() - start


figure, plot = plt.subplots(figsize=(7, 5))
for solver, iterations in (("position-based", 20), ("XPBD", 10), ("implicit", 1)):
    reference, _ = swing(solver, 3840, iterations)
    errors, seconds = [], []
    for steps in (60, 120, 240, 480, 960):
        positions, spent = swing(solver, steps, iterations)
        errors.append(np.sqrt(np.mean(np.sum((positions - reference) ** 2, axis=1))))
        seconds.append(spent * 1e3)
    plot.loglog(seconds, errors, "o-", label=solver)
    print(f"{solver}: {errors[0]:.4f} m at 60 steps per second, {errors[-1]:.4f} m at 960")
plot.set(xlabel="run time, ms", ylabel="error, root mean square, m",
         title="Against the same solver with 3,840 steps per second")
plot.legend()
plot.grid(True, which="both", alpha=0.3)
figure.tight_layout()
figure.savefig(sys.argv[1], dpi=100)
