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
    assert cloth.faces.shape[1] == 3 and cloth.inverse_masses[0, 0] == pytest.approx(121, rel=1e-3)


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
    missing = [name for name in pliant.functions
               if name.startswith("pli_body_enable_") and not hasattr(pliant.Body, name[len("pli_body_"):])]
    assert missing == []


def test_the_program_of_the_readme_runs(capsys):
    readme = (Path(__file__).parents[1] / "README.md").read_text()
    program = re.search(r"```python\n(.*?)```", readme, re.S)[1]
    exec(compile(program, "README.md", "exec"), {})
    assert re.fullmatch(r"lowest node: -?0\.\d+ m\n", capsys.readouterr().out)
