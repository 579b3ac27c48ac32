"""The Python package: equal bits with C, arrays without copies, lifetimes, errors, definitions by name."""

import gc
import hashlib
import re
from pathlib import Path

import numpy as np
import pytest

import pliant


@pytest.fixture
def context():
    return pliant.Context()


def make_cloth(world, side=11, height=1.0, pins=0):
    mesh = pliant.Mesh.create_patch(
        world._context, corner_00=(-1, height, -1), corner_10=(1, height, -1), corner_01=(-1, height, 1),
        corner_11=(1, height, 1), columns=side, rows=side, pins=pins, diagonals=True)
    mesh.set_total_mass(1.0)
    return pliant.Body.create(world, mesh, collision_margin=0.02, solver={"position_iterations": 10})


def make_ball(world, radius=0.5):
    sphere = pliant.Shape.create_sphere(world._context, radius)
    return pliant.Rigid.create(world, shapes=[sphere])


def test_free_fall(context):
    world = pliant.World(context, gravity=(0, -5, 0))
    cloth = make_cloth(world)
    for _ in range(60):
        world.step(1 / 60)
    assert cloth.positions.shape == (121, 3)
    assert cloth.velocities[:, 1] == pytest.approx(-5, abs=0.02)
    assert cloth.positions[0, 1] == pytest.approx(1 - 2.5, abs=0.06)
    assert world.get_gravity() == (0, -5, 0)


def test_cloth_lies_on_a_ball(context):
    world = pliant.World(context)
    cloth = make_cloth(world)
    ball = make_ball(world)
    cloth.enable_rigid_contacts(friction=0.8)
    for _ in range(120):
        world.step(1 / 60)
    distances = np.linalg.norm(cloth.positions, axis=1)
    assert distances.min() == pytest.approx(0.52, abs=0.02)
    assert cloth.positions[60, 1] > 0.5
    assert not ball.is_asleep()
    assert len(cloth.get_rigid_contacts()) > 10
    assert any("rigid" in feature["name"] for feature in cloth.get_features())


def test_arrays_show_memory(context):
    world = pliant.World(context)
    cloth = make_cloth(world)
    positions = cloth.positions
    before = positions.copy()
    world.step(1 / 60)
    assert positions[0, 1] < before[0, 1]
    assert not positions.flags.writeable and not positions.flags.owndata
    assert cloth.links.min() == 0 and cloth.links.max() == 120
    assert cloth.faces.shape[1] == 3 and cloth.inverse_masses[0] == pytest.approx(121, rel=1e-3)


def test_energy_of_a_falling_cloth(context):
    world = pliant.World(context)
    cloth = make_cloth(world, height=1.0)
    masses = 1 / cloth.inverse_masses  # one for each node, so that products with columns are of nodes
    assert masses.shape == (121,) and masses.sum() == pytest.approx(1, rel=1e-5)
    for _ in range(30):
        world.step(1 / 60)
    kinetic = 0.5 * (masses * (cloth.velocities**2).sum(axis=1)).sum()
    assert kinetic == pytest.approx(cloth.kinetic_energy(), rel=1e-5)
    potential = (masses * 10 * cloth.positions[:, 1]).sum()
    assert kinetic + potential == pytest.approx(10 - 10**2 * 0.5 / 60 / 2, rel=1e-4)  # g^2 t dt / 2 goes with the steps
    inverse_masses = cloth.inverse_masses
    with pytest.raises(BufferError):
        cloth.destroy()
    assert inverse_masses[0] > 0


def test_matrices_and_vectors(context):
    world = pliant.World(context)
    turn = np.array([(0, 0, 1), (0, 1, 0), (-1, 0, 0)])
    for rotation in (turn, turn.tolist(), {"rows": turn}, {"rows": turn.tolist()}):
        state = {"pose": {"rotation": rotation}, "inverse_mass": 0.5, "inverse_inertia_world": np.eye(3)}
        rigid = pliant.Rigid.create(world, kind="dynamic", state=state)
        np.testing.assert_array_equal(rigid.get_state()["pose"]["rotation"]["rows"], turn)
        rigid.set_state(rigid.get_state())
    cloth = make_cloth(world)
    cloth.transform((turn, (1, 2, 3)))
    np.testing.assert_allclose(cloth.positions[0], (0, 3, 4), atol=1e-6)
    with pytest.raises(ValueError, match=r"pli_vec3 has x, y, z, given was \(1, 2\)"):
        cloth.add_force((1, 2))
    with pytest.raises(ValueError, match="pli_vec3 has x, y, z, given was -9.81"):
        pliant.World(context, gravity=-9.81)


def test_arrays_keep_what_they_show(context):
    world = pliant.World(context)
    positions = make_cloth(world).positions
    expected = positions.copy()
    del world, context
    gc.collect()
    np.testing.assert_array_equal(positions, expected)


def test_a_body_does_not_go_below_its_arrays(context):
    world = pliant.World(context)
    cloth = make_cloth(world)
    positions = cloth.positions
    with pytest.raises(BufferError):
        cloth.destroy()
    with pytest.raises(BufferError):
        cloth.cut_link(0, 1, 0.5)
    assert positions[0, 1] == 1
    del positions
    cloth.destroy()
    assert world.bodies == []
    with pytest.raises(ReferenceError):
        cloth.get_bounds()


def test_bodies_outlive_their_python_names(context):
    world = pliant.World(context)
    make_cloth(world)
    gc.collect()
    assert len(world.bodies) == 1
    assert world.bodies[0] is world.bodies[0]


def test_errors_have_the_message_of_the_library(context):
    with pytest.raises(pliant.Error, match="gravity") as caught:
        pliant.World(context, gravity=(0, float("nan"), 0))
    assert caught.value.status == "PLI_ERROR_NOT_FINITE"
    world = pliant.World(context)
    cloth = make_cloth(world)
    with pytest.raises(pliant.Error, match="node 500"):
        cloth.set_node_mass(500, 1.0)
    with pytest.raises(pliant.Error, match="dt"):
        world.step(-1.0)
    with pytest.raises(TypeError, match="no field 'colour'"):
        pliant.World(context, colour="red")
    with pytest.raises(TypeError, match="wants"):
        cloth.set_node_mass(5)
    with pytest.raises(ValueError):
        cloth.set_state(np.zeros((3, 3)))


def test_parameters_by_name(context):
    world = pliant.World(context)
    mesh = pliant.Mesh.create_rope(context, from_=(0, 2, 0), to=(1, 2, 0), inner_nodes=3, pins=1)
    mesh.set_total_mass(mass=0.5)
    assert mesh.total_mass() == pytest.approx(0.5)
    assert mesh.positions.tolist() == [[x, 2, 0] for x in (0, 0.25, 0.5, 0.75, 1)]
    mesh.positions[:] = 0
    assert mesh.positions[4, 0] == 1 and pliant.Mesh(context).positions.shape == (0, 3)
    rope = pliant.Body.create(world, mesh=mesh, collision_margin=0.1)
    rope.set_node_mass(4, mass=0)
    world.step(dt=0.01)
    assert rope.inverse_masses[4] == 0 and rope.get_collision_margin() == pytest.approx(0.1)
    cloth = make_cloth(world)
    hit = cloth.cast_ray(from_=(0.1, 3, 0.1), to=(0.1, 0, 0.1))
    assert hit["point"][1] == pytest.approx(1, abs=0.01)
    assert cloth.cast_ray({"from": (0.1, 3, 0.1), "to": (0.1, 0, 0.1)}) == hit
    with pytest.raises(TypeError, match="float mass; left over: .*node"):
        rope.set_node_mass(4, 1.0, node=4)
    with pytest.raises(TypeError, match="wants .*float mass"):
        rope.set_node_mass(node=4)


@pytest.mark.parametrize("solver", ["position_based", "xpbd", "implicit"])
def test_solvers(context, solver):
    world = pliant.World(context)
    cloth = make_cloth(world, pins=15)
    if solver == "xpbd":
        cloth.enable_xpbd(substeps=10)
        cloth.enable_xpbd_links()
    elif solver == "implicit":
        cloth.enable_implicit(method="conjugate_gradient")
    cloth.enable_tethers()
    for _ in range(60):
        world.step(1 / 60)
    lengths = np.linalg.norm(np.diff(cloth.positions[cloth.links], axis=1)[:, 0], axis=1)
    assert np.isfinite(cloth.positions).all()
    assert lengths.max() == pytest.approx(0.2 * 2**0.5, rel=0.05)  # of a diagonal
    assert cloth.positions[60, 1] < 0.99


def test_anchors_forces_and_state(context):
    world = pliant.World(context)
    cloth = make_cloth(world)
    hook = pliant.Rigid.create(world, kind="kinematic", state={"pose": {"origin": (0, 1, 0)}})
    anchor = cloth.add_anchor(node=60, rigid=hook)
    cloth.add_force((0, 0.01, 0))
    for _ in range(30):
        world.step(1 / 60)
    assert cloth.positions[60] == pytest.approx((0, 1, 0), abs=1e-4)
    assert cloth.positions[0, 1] < 0.9
    cloth.remove_anchor(anchor)
    cloth.set_state(np.zeros((121, 3)) + cloth.positions + (0, 2, 0))
    assert cloth.positions[60, 1] == pytest.approx(3, abs=1e-3)
    assert np.abs(cloth.velocities).max() == 0


def test_arrays_are_as_long_as_their_counts_say(context):
    world = pliant.World(context)
    cloth = make_cloth(world)
    hook = pliant.Rigid.create(world, kind="kinematic")
    with pytest.raises(ValueError, match="nodes has 2 items, count = 5000000 wants 5000000"):
        cloth.attach_nodes([3, 4], 5000000, hook)
    cloth.attach_nodes([3, 4], 2, hook)
    corners = [(0, 0, 0), (1, 0, 0), (0, 0, 1)]
    with pytest.raises(ValueError, match="points has 3 items"):
        pliant.Shape.create_triangle_mesh(context, 30000000, corners, 1, [0, 2, 1], 0.1)
    with pytest.raises(ValueError, match="triangles has 3 items, triangle_count = 2 wants 6"):
        pliant.Shape.create_triangle_mesh(context, 3, corners, 2, [0, 2, 1], 0.1)
    pliant.Shape.create_triangle_mesh(context, 3, corners, 1, [(0, 2, 1)], 0.1)
    sphere = pliant.Shape.create_sphere(context, 0.5)
    with pytest.raises(ValueError, match="shape_poses"):
        pliant.Rigid.create(world, shapes=[sphere] * 4, shape_poses=[{}])
    with pytest.raises(ValueError, match="positions"):
        cloth.enable_targets(targets=[{"node": 5}, {"node": 6}], positions=np.zeros((200, 3)))


def test_vertices_that_share_a_node(context):
    count = 5000  # triangles with a node in common, each with vertices of its own
    vertices = np.zeros((3 * count, 3), np.float32)
    angles = np.arange(count + 1) * 2 * np.pi / (count + 1)
    rim = np.stack([np.cos(angles), 0 * angles, np.sin(angles)], axis=1) * 100
    vertices[1::3], vertices[2::3] = rim[:-1], rim[1:]
    nodes, mesh = pliant.Mesh.create_from_vertices(context, 3 * count, vertices, count, np.arange(3 * count))
    assert nodes.shape == (3 * count,) and (nodes[0::3] == nodes[0]).all()
    assert (nodes[2:-3:3] == nodes[4::3]).all() and nodes.max() == count + 1
    assert isinstance(mesh, pliant.Mesh)


def test_lists_name_the_objects_of_python(context):
    world = pliant.World(context)
    cloth = make_cloth(world, height=0.6)
    ball = make_ball(world)
    cloth.enable_rigid_contacts()
    cloth.enable_contact_events()
    cloth.add_anchor(node=0, rigid=ball)
    assert cloth.get_held_rigids() == [ball]
    events = []
    for _ in range(30):
        world.step(1 / 60)
        events += cloth.get_contact_events("begin")
    assert events and all(event["rigid"] is ball and event["other"] is None for event in events)


def test_a_file_does_not_go_below_arrays(context):
    world = pliant.World(context)
    cloth = make_cloth(world)
    size = world.file_size()
    memory = pliant.ffi.new("char[]", size)
    world.file_write({}, memory, size, None)
    cloth.cut_link(0, 1, 0.5)
    positions = cloth.positions
    with pytest.raises(BufferError):
        world.file_restore({}, memory, size)
    assert positions.shape == (123, 3)
    del positions
    world.file_restore({}, memory, size)
    assert cloth.positions.shape == (121, 3)
    again = pliant.World.file_create(context, {}, memory, size)
    assert again.bodies[0].state_hash() == cloth.state_hash()


def test_events_and_sleep(context):
    world = pliant.World(context)
    cloth = make_cloth(world, height=0.6)
    make_ball(world)
    cloth.enable_rigid_contacts(friction=1.0)
    cloth.enable_contact_events()
    seen = 0
    for _ in range(30):
        world.step(1 / 60)
        seen += len(cloth.get_contact_events("begin"))
    assert seen > 0
    cloth.enable_sleep()
    cloth.set_asleep(True)
    assert cloth.is_asleep()
    world.step(1 / 60)
    assert [event["kind"] for event in world.get_events()] == [4]


def test_snapshots(context):
    world = pliant.World(context)
    cloth = make_cloth(world)
    world.step(1 / 60)
    snapshot = world.save()
    after = []
    for _ in range(2):
        for _ in range(20):
            world.step(1 / 60)
        after.append(cloth.state_hash())
        world.restore(snapshot)
    assert after[0] == after[1]
    damaged = bytearray(snapshot)
    damaged[300] ^= 1
    with pytest.raises(pliant.Error, match="pli_world_restore"):
        world.restore(bytes(damaged))
    assert cloth.state_hash() != after[0]


def test_threads_have_equal_bits():
    digests = set()
    for threads in (1, 3):
        world = pliant.World(pliant.Context(threads=threads))
        cloths = [make_cloth(world, side=41, height=1 + 0.1 * i) for i in range(4)]
        make_ball(world)
        for cloth in cloths:
            cloth.enable_colored_links()
            cloth.enable_rigid_contacts()
        for _ in range(20):
            world.step(1 / 60)
        digests.add(hashlib.sha256(b"".join(cloth.positions.tobytes() for cloth in cloths)).hexdigest())
    assert len(digests) == 1


def test_names_of_the_headers_are_there():
    assert pliant.MAX_COORDINATE == 1e6
    assert "pli_body_enable_tethers(" in pliant.Body.enable_tethers.__doc__
    assert "slack=0.01" in pliant.Body.enable_tethers.__doc__
    assert 'solver={"velocity_iterations": 0, "position_iterations": 8,' in pliant.Body.create.__doc__
    missing = [name for name in pliant.functions
               if name.startswith("pli_body_enable_") and not hasattr(pliant.Body, name[len("pli_body_"):])]
    assert missing == []


def test_the_program_of_the_readme_runs(capsys):
    readme = (Path(__file__).parents[1] / "README.md").read_text()
    program = re.search(r"```python\n(.*?)```", readme, re.S)[1]
    exec(compile(program, "README.md", "exec"), {})
    assert re.fullmatch(r"lowest node: -?0\.\d+ m\n", capsys.readouterr().out)


def test_memory_of_the_caller(context):
    world = pliant.World(context)
    cloth = make_cloth(world)
    cloth.enable_normals()
    vertices = np.zeros((121, 6), np.float32)
    world.step(1 / 60)
    cloth.write_vertices({"vertices": vertices, "vertex_count": 121}, 1.0)
    np.testing.assert_array_equal(vertices[:, :3], cloth.positions)
    np.testing.assert_allclose(vertices[:, 3:], cloth.normals, atol=1e-6)
    file = bytearray(world.file_size())
    assert world.file_write(file, len(file)) == len(file)
    again = pliant.World.file_create(context, bytes(file), len(file))
    assert again.bodies[0].state_hash() == cloth.state_hash()
