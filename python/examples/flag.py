"""A flag in the wind, drawn every second.

usage: flag.py PICTURE
"""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import pliant

context = pliant.Context()
world = pliant.World(context)
mesh = pliant.Mesh.create_patch(
    context, corner_00=(0, 0, 0), corner_10=(1.5, 0, 0), corner_01=(0, 1, 0), corner_11=(1.5, 1, 0), columns=31,
    rows=21, diagonals=True)
mesh.set_total_mass(0.15)
flag = pliant.Body.create(world, mesh, solver={"position_iterations": 20})
flag.enable_colored_links()
for node, (x, _, _) in enumerate(flag.positions.copy()):
    if x == 0:
        flag.set_node_mass(node, 0.0)  # the pole
flag.enable_aero(model="face_two_sided", lift=0.1, drag=0.2)
flag.set_wind((8.0, 0.0, 3.0))

figure, axes = plt.subplots(1, 3, figsize=(12, 4.6), subplot_kw={"projection": "3d"})
for second, plot in enumerate(axes, start=1):
    for _ in range(60):
        world.step(1 / 60)
    x, y, z = flag.positions.T
    plot.plot_trisurf(x, z, y, triangles=flag.faces, color="tab:red", edgecolor="none", alpha=0.95)
    plot.set(title=f"{second} s", xlim=(0, 1.5), ylim=(-0.75, 0.75), zlim=(-0.3, 1.2), xlabel="x in m", ylabel="z in m",
             zlabel="y in m")
figure.subplots_adjust(left=0.02, right=0.95, bottom=0.08, top=0.95, wspace=0.18)
figure.savefig(sys.argv[1], dpi=100)
print(f"fastest node: {abs(flag.velocities).max():.2f} m/s, picture: {sys.argv[1]}")
