"""Robots of URDF files: motions of closed equations, inertia, places at the start, refusals."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import ancfsparse as ancf
from tests.solve.refusals import assert_refused

yourdfpy = pytest.importorskip("yourdfpy")
G = 9.81

# The inertia of the upper link is given along axes that are turned by a right angle.
ARM = """
<robot name="arm">
  <link name="base"><visual><geometry><box size="1 1 1"/></geometry></visual></link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 1"/><axis xyz="0 2 0"/>
    <limit lower="-2" upper="2" effort="100" velocity="3"/><dynamics damping="0.2"/>
  </joint>
  <link name="upper"><inertial><origin xyz="0.25 0 0" rpy="1.5707963267948966 0 0"/>
    <mass value="4"/><inertia ixx="0.01" iyy="0.03" izz="0.035"/></inertial></link>
  <joint name="elbow" type="continuous">
    <parent link="upper"/><child link="fore"/><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/>
  </joint>
  <link name="fore"><inertial><origin xyz="0.2 0 0"/>
    <mass value="2"/><inertia ixx="0.01" iyy="0.03" izz="0.03"/></inertial></link>
  <joint name="wrist" type="fixed">
    <parent link="fore"/><child link="hand"/><origin xyz="0.4 0 0" rpy="0 1.5707963267948966 0"/>
  </joint>
  <link name="hand"/>
  <transmission name="motor"/>
</robot>
"""

SLIDER = """
<robot name="slider">
  <link name="rail"/>
  <joint name="slide" type="prismatic">
    <parent link="rail"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-0.5" upper="0.3" effort="1" velocity="1"/>
    <dynamics damping="0.5" friction="0.2"/>
  </joint>
  <link name="cart"><inertial>
    <mass value="2"/><inertia ixx="0.02" iyy="0.02" izz="0.02"/></inertial></link>
  <joint name="hinge" type="continuous">
    <parent link="cart"/><child link="bob"/><origin xyz="0 0.1 0"/><axis xyz="0 1 0"/>
  </joint>
  <link name="bob"><inertial><origin xyz="0.4 0 0"/>
    <mass value="1"/><inertia ixx="0.01" iyy="0.02" izz="0.02"/></inertial></link>
  <joint name="wheel" type="continuous">
    <parent link="cart"/><child link="disc"/><origin xyz="0 0.2 0"/><axis xyz="0 1 0"/>
    <mimic joint="hinge" multiplier="-2" offset="0.3"/>
  </joint>
  <link name="disc"><inertial>
    <mass value="0.5"/><inertia ixx="0.02" iyy="0.03" izz="0.02"/></inertial></link>
</robot>
"""


@pytest.fixture
def write(tmp_path):
    def write(text):
        file = tmp_path / "robot.urdf"
        file.write_text(text, encoding="utf-8")
        return file

    return write


def spatial():
    return ancf.Scene((0.0, 0.0, -G))


def double_pendulum(t_end, shoulder, elbow):
    """Return the angles to the horizontal at the end, downwards, by Lagrange's equations."""
    m1, m2, a1, a2, length, damping = 4.0, 2.0, 0.25, 0.2, 0.5, 0.2
    moment1, moment2 = 0.035 + m1 * a1**2 + m2 * length**2, 0.03 + m2 * a2**2

    def rates(t, x):
        one, two, rate_one, rate_two = x
        coupling = m2 * length * a2 * np.cos(one - two)
        centrifugal = m2 * length * a2 * np.sin(one - two)
        forces = [
            (m1 * a1 + m2 * length) * G * np.cos(one)
            - centrifugal * rate_two**2
            - damping * rate_one,
            m2 * a2 * G * np.cos(two) + centrifugal * rate_one**2,
        ]
        mass = [[moment1, coupling], [coupling, moment2]]
        return [rate_one, rate_two, *np.linalg.solve(mass, forces)]

    start = [shoulder, shoulder + elbow, 0.0, 0.0]
    return solve_ivp(rates, (0, t_end), start, "DOP853", rtol=1e-11, atol=1e-12).y[:2, -1]


def test_an_arm_moves_by_the_equations_of_a_double_pendulum(write):
    scene = spatial()
    robot = ancf.urdf.add(scene, write(ARM), start={"shoulder": 0.4, "elbow": -0.7}, stops={})
    run = ancf.simulate(scene, 1.0, 1e-3, integrator=ancf.DormandPrince())
    one, two = double_pendulum(1.0, 0.4, -0.7)
    elbow = np.array([0.5 * np.cos(one), 0.0, 1.0 - 0.5 * np.sin(one)])
    hand = elbow + 0.4 * np.array([np.cos(two), 0.0, -np.sin(two)])
    np.testing.assert_allclose(run.position(robot.links["fore"].point())[-1], elbow, atol=1e-8)
    np.testing.assert_allclose(run.position(robot.links["hand"].point())[-1], hand, atol=1e-8)


def test_a_mechanism_moves_as_the_same_one_by_hand(write):
    """A cart meets its stop, with friction and damping, and a wheel turns with the pendulum.

    By hand, frames of other orientations begin at the centres of mass.
    """
    scene = spatial()
    robot = ancf.urdf.add(
        scene, write(SLIDER), start={"slide": 0.2}, stops={"slide": 1e3}, slip=0.05
    )
    assert robot.start == {"slide": 0.2, "hinge": 0.0, "wheel": 0.3}

    other = spatial()
    cart = other.add_body(position=(0.2, 0, 0), mass=2.0, inertia=(0.02, 0.02, 0.02))
    quarter = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))
    bob = other.add_body(
        position=(0.6, 0.1, 0), mass=1.0, inertia=(0.02, 0.01, 0.02), orientation=quarter
    )
    disc = other.add_body(position=(0.2, 0.2, 0), mass=0.5, inertia=(0.02, 0.03, 0.02))
    slide = other.prismatic(cart.origin, axis=(1, 0, 0))
    hinge = other.revolute(bob.at((0, 0.4, 0)), cart.at((0, 0.1, 0)), axis=(0, 1, 0))
    wheel = other.revolute(disc.origin, cart.at((0, 0.2, 0)), axis=(0, 1, 0))
    other.gear(wheel, hinge, -2.0)
    other.joint_spring(slide, damping=0.5)
    other.joint_friction(slide, 0.2, slip=0.05)
    other.joint_stop(slide, -0.7, 0.1, stiffness=1e3)

    options = {"t_end": 1.0, "dt": 1e-3, "integrator": ancf.DormandPrince()}
    ours, theirs = ancf.simulate(scene, **options), ancf.simulate(other, **options)
    path = ours.position(robot.links["cart"].point())
    assert path[:, 0].max() > 0.3  # m, beyond the limit
    np.testing.assert_allclose(path, theirs.position(cart.origin), atol=1e-7)
    np.testing.assert_allclose(
        ours.position(robot.links["bob"].point((0.4, 0, 0))), theirs.position(bob.origin), atol=1e-7
    )
    np.testing.assert_allclose(
        ours.position(robot.links["disc"].point((0.1, 0, 0.0))),
        theirs.position(disc.at((0.1 * np.cos(0.3), 0, -0.1 * np.sin(0.3)))),
        atol=1e-7,
    )


def test_the_inertia_of_links_in_one_body_is_that_of_their_points(write):
    """Links of point masses, joined and turned at will, against the sum over all points."""
    random = np.random.default_rng(3)

    def frame():
        xyz, rpy = random.uniform(-1, 1, 3), random.uniform(-3, 3, 3)
        text = f'<origin xyz="{" ".join(map(str, xyz))}" rpy="{" ".join(map(str, rpy))}"/>'
        matrix = np.eye(4)
        matrix[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()
        matrix[:3, 3] = xyz
        return text, matrix

    links, points, masses = ["<link name='base'/>"], [], []
    place = np.eye(4)
    for name in ("one", "two", "three"):
        kind, parent = ("continuous", "base") if name == "one" else ("fixed", before)  # noqa: F821
        joint, matrix = frame()
        place = np.eye(4) if name == "one" else place @ matrix
        weights, cloud = random.uniform(0.5, 1, 5), random.uniform(-0.2, 0.2, (5, 3))
        cloud -= weights @ cloud / weights.sum()
        tensor = sum(
            m * (x @ x * np.eye(3) - np.outer(x, x)) for m, x in zip(weights, cloud, strict=True)
        )
        origin, own = frame()
        moments = " ".join(
            f'i{"xyz"[i]}{"xyz"[j]}="{tensor[i, j]}"' for i in range(3) for j in range(i, 3)
        )
        links.append(
            f"<link name='{name}'><inertial>{origin}<mass value='{weights.sum()}'/>"
            f"<inertia {moments}/></inertial></link><joint name='to {name}' type='{kind}'>"
            f"<parent link='{parent}'/><child link='{name}'/>{joint}</joint>"
        )
        turned = np.c_[cloud, np.ones(5)] @ (place @ own).T
        points.append(turned[:, :3])
        masses.append(weights)
        before = name  # noqa: F841
    robot = ancf.urdf.add(spatial(), write(f"<robot name='r'>{''.join(links)}</robot>"))
    body = robot.links["three"].body
    assert body is robot.links["one"].body
    arms = np.c_[np.ones(15), np.concatenate(points)]
    expected = arms.T @ (np.concatenate(masses)[:, None] * arms)
    np.testing.assert_allclose(body.spread, expected, atol=1e-12)
    corner = place @ (0.1, 0.2, 0.3, 1.0)
    np.testing.assert_allclose(robot.links["three"].point((0.1, 0.2, 0.3)).offsets, corner[:3])


def test_links_start_at_the_places_that_another_program_computes(write):
    text = ARM.replace('<origin xyz="0.5 0 0"/>', '<origin xyz="0.5 0.1 0" rpy="0.3 -0.2 1"/>')
    start = {"shoulder": 0.4, "elbow": -1.1}
    half = 0.5 * 1.2
    robot = ancf.urdf.add(
        spatial(), write(text), position=(1, 2, 3), start=start, stops=1.0,
        orientation=(np.cos(half), 0, 0, np.sin(half)),
    )  # fmt: skip
    other = yourdfpy.URDF.load(str(write(text)))
    other.update_cfg(start)
    turn = Rotation.from_rotvec((0, 0, 1.2)).as_matrix()
    point = np.array([0.1, -0.2, 0.3, 1.0])
    for name, link in robot.links.items():
        expected = turn @ (other.get_transform(name) @ point)[:3] + (1, 2, 3)
        np.testing.assert_allclose(link.start_position(point[:3]), expected, atol=1e-12)
        if name != "base":
            np.testing.assert_allclose(link.point(point[:3]).position, expected, atol=1e-12)


def test_a_free_robot_falls_and_a_floating_joint_leaves_its_link_free(write):
    text = ARM.replace('<link name="base">', '<link name="base"><inertial><mass value="1"/>'
                       '<inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>')  # fmt: skip
    floating = ARM.replace('name="elbow" type="continuous"', 'name="elbow" type="floating"')
    for file, options, names in (
        (text, {"fixed": False}, ("base", "upper", "hand")),
        (floating, {}, ("fore", "hand")),
    ):
        scene = spatial()
        robot = ancf.urdf.add(scene, write(file), stops={}, **options)
        run = ancf.simulate(scene, 0.1, 1e-3, integrator=ancf.DormandPrince())
        for name in names:
            point = robot.links[name].point()
            fallen = run.position(point)[-1] - point.position
            np.testing.assert_allclose(fallen, (0, 0, -0.5 * G * 0.1**2), atol=1e-12)


def test_joints_are_driven_and_limits_and_the_rest_are_kept(write, tmp_path):
    scene = spatial()
    robot = ancf.urdf.add(scene, write(ARM), start={"shoulder": 0.5}, stops=1e4, prefix="left ")
    assert robot.limits["shoulder"] == ancf.urdf.Limits(-2.0, 2.0, 100.0, 3.0)
    assert robot.limits["elbow"].is_range is False
    assert robot.unused == {"visual": ("base",), "transmission": ("motor",)}
    assert repr(robot) == "robot 'arm': links 4, joints 2, without transmission, visual"
    assert [each.name for each in scene.bodies] == ["left upper", "left fore"]
    turn = ancf.Ramp(0.25, 0.2, smooth=True)
    scene.drive_joint(robot.joints["shoulder"], turn)
    scene.drive_joint(robot.joints["elbow"], lambda t: -turn(t))
    run = ancf.simulate(scene, 0.4, 1e-3)
    end = (0.5 * np.cos(0.75) + 0.4 * np.cos(0.5), 0, 1 - 0.5 * np.sin(0.75) - 0.4 * np.sin(0.5))
    np.testing.assert_allclose(run.position(robot.links["hand"].point())[-1], end, atol=1e-6)


def test_a_fixed_joint_has_no_axis_and_no_dynamics(write):
    """Files state them for joints that were fixed by hand."""
    extra = '<axis xyz="0 0 0"/><dynamics damping="1" friction="2"/><mimic joint="elbow"/>'
    text = ARM.replace('<child link="hand"/>', f'<child link="hand"/>{extra}')
    robot = ancf.urdf.add(spatial(), write(text), stops={})
    assert robot.unused["dynamics"] == robot.unused["mimic"] == ("wrist",)
    assert list(robot.joints) == ["shoulder", "elbow"]


def test_a_scene_with_a_robot_is_saved(write, tmp_path):
    scene = spatial()
    ancf.urdf.add(scene, write(SLIDER), start={"slide": 0.2}, stops=1e3, slip=0.05)
    scene.save(tmp_path / "scene.toml")
    assert ancf.Scene.load(tmp_path / "scene.toml") == scene


PLANAR = ARM.replace('type="continuous"', 'type="planar"')
LOOP = ARM.replace('<child link="upper"/>', '<child link="base"/>')


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        (ARM, {}, r"'shoulder' has limits: give stops \[N m/rad\]"),
        (SLIDER, {"stops": {}}, r"'slide' has friction: give slip \[m/s\]"),
        (ARM, {"stops": -1.0}, "stops of joint 'shoulder' must be positive"),
        (ARM, {"stops": {"elbow": 1.0}}, "unknown joint in stops 'elbow'"),
        (ARM.replace('upper="2"', 'upper="5"'), {"stops": 1.0}, "-2 to 5, whose range is a turn"),
        (ARM.replace('lower="-2" upper="2"', ""), {"stops": 1.0}, "0 to 0, whose range is empty"),
        (ARM, {"start": {"elbo": 1.0}}, "unknown joint in start 'elbo': did you mean 'elbow'"),
        (ARM, {"start": {"shoulder": 2.5}}, "starts at 2.5, outside its limits -2 to 2"),
        (ARM, {"start": 1.0}, "start must name joints"),
        (ARM, {"prefix": 1}, "prefix must be a text"),
        (ARM, {"fixed": False, "stops": {}}, "the body of 'base' moves and has no mass"),
        (SLIDER, {"start": {"wheel": 1.0}}, "'wheel' follows that of 'hinge'"),
        (PLANAR, {}, "joint 'elbow' is planar"),
        (LOOP, {}, "must have one link without a parent, got 'upper'|form a loop"),
        (ARM.replace('"revolute"', '"ball"'), {}, "unknown type of joint 'shoulder' 'ball'"),
        (ARM.replace('child link="hand"', 'child link="hnd"'), {}, "'hnd', which .* lacks: did"),
        (ARM.replace('child link="hand"', 'child link="fore"'), {}, "child of two joints"),
        (ARM.replace('"elbow"', '"shoulder"'), {}, "two joints named 'shoulder'"),
        (ARM.replace('value="4"', 'value="-4"'), {}, "mass of link 'upper' must not be negative"),
        (ARM.replace('value="4"', 'value="${m}"'), {}, "cannot be read as a URDF file"),
        (ARM.replace('ixx="0.01" iyy="0.03"', 'iyy="0.03"'), {}, "of link 'upper' lacks ixx"),
        (ARM.replace('damping="0.2"', 'damping="nan"'), {}, "damping of joint 'shoulder' must be"),
        (ARM.replace('damping="0.2"', 'damping="x"'), {}, "must be a number, got 'x'"),
        (ARM.replace('xyz="0 2 0"', 'xyz="0 0 0"'), {}, "axis of joint 'shoulder' must be"),
        (ARM.replace('xyz="0.5 0 0"', 'xyz="nan 0 0"'), {}, "origin of the joint 'elbow' must be"),
        (ARM.replace('upper="2"', 'upper="-3"'), {}, "lower limit of joint 'shoulder' must not"),
        (ARM.replace('type="continuous"', 'type="revolute"'), {}, "'elbow' .* has no limit"),
        ("<robot name='empty'/>", {}, "has no robot with links"),
        ("<sdf><model name='m'/></sdf>", {}, "cannot be read as a URDF file|has no robot"),
        (ARM.replace("</robot>", ""), {}, r"cannot be read .*\(ParseError: .*line"),
        (SLIDER.replace('joint="hinge"', 'joint="wheel"'), {}, "cannot follow 'wheel'"),
        (SLIDER.replace('joint="hinge"', 'joint="hing"'), {}, "that joint 'wheel' follows 'hing'"),
    ],
)
def test_bad_input_is_refused(write, text, options, message):
    assert_refused(message, ancf.urdf.add, spatial(), write(text), **options)


def test_planar_scenes_and_missing_files_are_refused(write, tmp_path):
    assert_refused("spatial scene", ancf.urdf.add, ancf.Scene((0, -G)), write(ARM))
    assert_refused("is not a file", ancf.urdf.add, spatial(), tmp_path / "missing.urdf")
    robot = ancf.urdf.add(spatial(), write(ARM), stops={})
    assert_refused("'base' is fixed in space", robot.links["base"].point)
