"""Each neglected effect beside the richer model, over a decade of what it depends on."""

from itertools import combinations

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.model_error.neglected_energies import neglected_effects
from ancfsparse.plans.model_error.quasi_static_error import inertia_error
from ancfsparse.plans.trial_runs.trial_runs import as_trajectory
from tests.beams import build_beam
from tests.grids import level_grid
from tests.plans.comparison import distance_from_shorter_steps

FACTOR = 2.0
"""Within which estimates are right."""


def close(estimate, truth):
    assert truth / FACTOR <= estimate <= FACTOR * truth


@pytest.mark.parametrize("height", [0.1, 0.3])
def test_shear(height):
    """A cantilever under a tip force: 0.78 (b / L)^2 of its deflection."""

    def bent(element, n, **options):
        scene = ancf.Scene(gravity=(0.0, 0.0))
        section, material = ancf.Rectangle(height, height), ancf.Material(1e9, 1000.0, 0.3)
        beam = scene.add_beam(element, (0, 0), (1, 0), n, section, material, **options)
        scene.clamp(beam.start)
        scene.point_force(beam.end, ancf.Ramp((0.0, -0.003 * 1e9 * height**4 / 12.0), 1.0))
        return scene, beam.end

    scene, end = bent("thin", 4)
    run = ancf.quasi_static(scene, 1.0, 0.25)
    rich = bent("thin", 16), bent("thick", 16, curvature="section", section_strain="nodal")
    y = [ancf.solve_static(each, t=1.0).position(point)[1] for each, point in rich]
    error_model = neglected_effects(run, ancf.position(end))
    close(error_model["shear"], abs(y[1] - y[0]))
    assert error_model["shear"] / 1e-3 == pytest.approx(0.78 * height**2, rel=0.03)

    def march(changed):
        return ancf.quasi_static(changed, 1.0, 0.25)

    measured = neglected_effects(run, ancf.position(end), march)
    assert measured["shear"] == pytest.approx(error_model["shear"], rel=0.02)


@pytest.mark.parametrize("load", [0.03, 0.1])
def test_strains_of_a_bent_axis(load):
    """Cables and beams under a tip force agree in the tension, and not in its strain."""

    def bent(element, n, **options):
        scene, beam = build_beam(
            element, (0, 0), (1, 0), n, ancf.Circle(0.05), ancf.Material(1e9, 1000.0, 0.3), "clamp",
            gravity=(0.0, 0.0), **options,
        )  # fmt: skip
        scene.point_force(beam.end, (0.0, -load * 1e9 * np.pi / 64.0 * 0.05**4))
        return ancf.solve_static(scene), beam

    cable, beam = bent("thin", 32), bent("thick", 64, curvature="section", section_strain="nodal")
    strains = [each.strain(body, [body.at(0.25)]).item() for each, body in (cable, beam)]
    run, body = as_trajectory(cable[0]), cable[1]
    error_model = neglected_effects(run, ancf.strain(body.at(0.25)))
    close(error_model["stretch"], abs(strains[1] - strains[0]))


@pytest.mark.parametrize("height", [0.05, 0.2])
def test_rotary_inertia(height):
    """A beam let go from its deflection; its section does not shear."""
    inertia = height**4 / 12.0
    section = ancf.Section(height**2, inertia, inertia, 2.0 * inertia, 1e4)

    def pinned(element, n, load, **options):
        scene, beam = build_beam(
            element, (0, 0), (1, 0), n, section, ancf.Material(1e9, 1000.0, 0.0), "pin", "pin",
            gravity=(0.0, 0.0), **options,
        )  # fmt: skip
        scene.point_force(beam.node(n // 2), (0.0, 0.048 * 1e9 * inertia * load))
        return scene, beam.node(n // 2)

    t_end = 0.3 / ancf.modes(pinned("thin", 8, 0.0)[0], 1).frequencies[0]

    def released(element, n, **options):
        start = ancf.solve_static(pinned(element, n, 1.0, **options)[0])
        scene, middle = pinned(element, n, 0.0, **options)
        return scene, middle, ancf.simulate(scene, t_end, t_end / 200, start=start)

    _, middle, run = released("thin", 8)
    _, one, plain = released("thin", 24)
    _, other, rich = released("thick", 24, curvature="section", section_strain="nodal")
    truth = np.abs(rich.position(other) - plain.position(one)).max()
    error_model = neglected_effects(run, ancf.position(middle))
    close(error_model["rotary inertia"], truth)


@pytest.mark.parametrize("height", [0.01, 0.03])
@pytest.mark.parametrize("ask", [ancf.section_force, ancf.velocity])
def test_waves_after_a_pulse(height, ask):
    """Moments and velocities have waves of all lengths, the shortest of which shear most.

    Ratios of energies alone give a fifteenth of the difference; with rates, 1 to 12 times.
    """
    made = ancf.Rectangle(height, height), ancf.Material(2e9, 1000.0, 0.3)

    def struck(element, n, **options):
        scene, beam = build_beam(
            element, (0, 0), (1, 0), n, *made, "pin", "pin", gravity=(0.0, 0.0), **options
        )
        t_end = 1.0 / ancf.modes(scene, 1).frequencies[0]
        pulse = ancf.Pulse((0.0, 1e-3 * 2e9 * height**4 / 12.0), 0.0, 0.2 * t_end)
        scene.point_force(beam.node(n // 2), pulse)
        run = ancf.simulate(scene, t_end, t_end / 6400, save_every=4)
        return scene, ask(beam.at(0.3)), run

    _, quantity, run = struck("thin", 32)
    _, of_cable, plain = struck("thin", 64)
    _, of_beam, rich = struck("thick", 64, curvature="section", section_strain="nodal")
    truth = np.abs(of_beam.history(rich) - of_cable.history(plain)).max()
    effects = neglected_effects(run, quantity)
    assert truth < effects["shear"] + effects["rotary inertia"] < 12.0 * truth


@pytest.mark.parametrize("pull", [100.0, 1000.0])
def test_bending_of_strings(pull):
    """A taut line under an even load, with EI / N L^2 of 1 % and 0.1 %."""
    bending = 1e8 * np.pi * 0.01**4 / 64.0

    def line(element):
        scene, cord = build_beam(
            element, (0, 0), (1, 0), 24, ancf.Circle(0.01), ancf.Material(1e8, 500.0), "pin", "pin",
            gravity=(0.0, 0.0), tension=pull * bending,
        )  # fmt: skip
        scene.distributed_force(cord, ancf.Ramp((0.0, -0.005 * pull * bending), 1.0))
        return scene, cord.node(12)

    scene, middle = line("string")
    run = ancf.quasi_static(scene, 1.0, 0.5)
    rich, other = line("thin")
    truth = abs(run.position(middle)[-1, 1] - ancf.solve_static(rich, t=1.0).position(other)[1])
    close(neglected_effects(run, ancf.position(middle))["bending"], truth)


@pytest.mark.parametrize("place", [0.2, 0.34, 0.5])
@pytest.mark.parametrize("weight", [0.0, 9.81])
def test_bending_of_strings_at_kinks(place, weight):
    """A force inside a taut line, also a small one that is added to its weight."""

    def line(element, nodes):
        scene = ancf.Scene(gravity=(0.0, -weight))
        made = ancf.Circle(0.002), ancf.Material(5e10, 3000.0)
        cord = scene.add_beam(element, (0, 0), (2, 0), len(nodes) - 1, *made, tension=800.0,
                              nodes=tuple(nodes))  # fmt: skip
        scene.pin(cord.start)
        scene.pin(cord.end)
        point = cord.at(place * cord.length)
        scene.point_force(point, (0.0, -16.0 if weight == 0.0 else -0.02))
        return scene, point

    sides = [np.linspace(0.0, place, 5)[:-1], np.linspace(place, 1.0, 7)]
    scene, point = line("string", np.concatenate(sides))
    run = as_trajectory(ancf.solve_static(scene))
    sides = [place * np.linspace(0.0, 1.0, 200)[:-1], np.linspace(place, 1.0, 200)]
    rich, other = line("thin", np.concatenate(sides))
    truth = abs(run.position(point)[-1, 1] - ancf.solve_static(rich).position(other)[1])
    if weight != 0.0:  # both have the same sag by weight to 1e-7 m
        truth = 0.5 * 0.02 / 800.0 * np.sqrt(5e10 * np.pi * 0.002**4 / 64.0 / 800.0)
    close(neglected_effects(run, ancf.static_deflection(point))["bending"], truth)


def test_bending_of_strings_in_a_net():
    """Every line of a net counts, and a net under more tension bends relatively less."""
    error_model = []
    for stretch in (1e-3, 1e-2):
        scene = ancf.Scene(gravity=(0.0, 0.0, 0.0))
        nodes, edges, number = level_grid(7)
        made = ancf.Circle(0.01), ancf.Material(1e8, 500.0)
        net = scene.add_mesh(nodes, edges, "string", *made)
        for k in np.unique(number[[0, -1]].ravel().tolist() + number[:, [0, -1]].ravel().tolist()):
            place = nodes[k] + stretch * (nodes[k] - 0.5) * (1.0, 1.0, 0.0)
            scene.drive(net.node(int(k)), place)
        scene.distributed_force(net, ancf.Ramp((0.0, 0.0, -0.01), 1.0))
        begin = ancf.solve_static(scene)
        run = ancf.quasi_static(scene, 1.0, 0.5, start=begin)
        middle = net.node(24)
        error_model.append(
            neglected_effects(run, ancf.position(middle))["bending"]
            / np.abs(run.position(middle)[-1, 2])
        )
    # EI pi^2 / N L^2 of one line, and 12 in place of pi^2 for an even load.
    bending, area = np.pi * 0.01**4 / 64.0, np.pi * 0.01**2 / 4.0
    for share, stretch in zip(error_model, (1e-3, 1e-2), strict=True):
        close(share, np.pi**2 * bending / (area * stretch))


@pytest.mark.parametrize("youngs", [1e8, 1e9])
def test_stretch(youngs):
    """The pendulum with Green's and with Biot's strain, whose bending differs by the stretch."""

    def pendulum(**options):
        made = ancf.Rectangle(0.01, 0.01), ancf.Material(youngs, 4000.0)
        scene, rod = build_beam("thin", (0, 0), (2, 0), 16, *made, "pin", **options)
        return scene, rod.end

    def march(scene):
        return ancf.simulate(scene, 1.0, dt=1e-3)

    (scene, end), (rich, other) = pendulum(), pendulum(strain="biot")
    run = march(scene)
    truth = np.abs(run.position(end) - march(rich).position(other)).max()
    error_model = neglected_effects(run, ancf.position(end), march)
    close(error_model["stretch"], truth)
    assert error_model["shear"] < error_model["stretch"]


@pytest.mark.parametrize("element", ["thin", "string"])
@pytest.mark.parametrize("pull", [0.005, 0.02])
def test_stretch_of_taut_lines(pull, element):
    """The sag of a line that is pulled: Green's strain makes it 1 + 3/2 of its strain tauter."""

    def sagging(kind, n, **options):
        made = ancf.Circle(0.002), ancf.Material(1e8, 1000.0)
        scene, line = build_beam(kind, (0, 0), (1, 0), n, *made, "pin", **options)
        scene.drive(line.end, (1.0 + pull, 0.0))
        rest = ancf.solve_static(scene)
        return scene, line.at(0.5), rest

    y = []
    for strain in ("green", "biot"):
        _, middle, rest = sagging("thin", 32, strain=strain)
        y.append(rest.displacement(middle)[1])
    _, middle, rest = sagging(element, 16)

    def march(changed):
        return as_trajectory(ancf.solve_static(changed))

    error_model = neglected_effects(as_trajectory(rest), ancf.static_deflection(middle), march)
    assert error_model["stretch"] == pytest.approx(abs(y[1] - y[0]), rel=0.3)


@pytest.mark.parametrize("droop", [3.0, 6.0])
def test_stretch_of_slack_spans(droop):
    """Small differences of the tension grow in the motion of a beam between two pins.

    The size of the position times the ratio of energies is a fifth of the difference.
    """
    area, inertia = np.pi * 0.03**2 / 4.0, np.pi * 0.03**4 / 64.0
    section = ancf.Section(area, inertia, inertia, 2.0 * inertia, 1e4)  # does not shear
    material = ancf.Material(9.81 * 2000.0 * area / (droop * inertia), 2000.0, 0.3)

    def span(element, n, **options):
        scene, beam = build_beam(
            element, (0, 0), (1, 0), n, section, material, "pin", "pin", **options
        )
        scene.point_force(beam.node(n // 2), ancf.Ramp((0.0, -6.0), 0.08, smooth=True))
        return scene, beam.at(0.7)

    def march(scene):
        return ancf.simulate(scene, 1.4, 1.4 / 1600, save_every=4)

    sheared = {"curvature": "section", "section_strain": "nodal"}
    y = []
    for element, options in (("thin", {}), ("thin", {"strain": "biot"}), ("thick", sheared)):
        scene, point = span(element, 48, **options)
        y.append(march(scene).position(point))
    truth = max(np.linalg.norm(a - b, axis=1).max() for a, b in combinations(y, 2))
    scene, point = span("thin", 16)
    error_model = neglected_effects(march(scene), ancf.position(point), march, 0.5 * truth)
    close(error_model["stretch"], truth)


@pytest.mark.parametrize("load", [8.0, 40.0, "ramp"])
def test_inertia_of_a_quasi_static_run(load):
    """Of a load that is so many times as slow as the first mode, and of one that sets in."""
    made = ancf.Rectangle(0.01, 0.01), ancf.Material(2e9, 1000.0)
    scene, beam = build_beam("thin", (0, 0), (1, 0), 6, *made, "clamp", gravity=(0.0, 0.0))
    if load == "ramp":
        t_end, steps = 4.0, 40
        scene.point_force(beam.end, ancf.Ramp((0.0, 0.05), 4.0))
    else:
        omega = 2.0 * np.pi * ancf.modes(scene, 1).frequencies[0] / load
        t_end, steps = 2.0 * np.pi / omega, 200
        scene.point_force(beam.end, lambda t: (0.0, 1e-3 * (1.0 - np.cos(omega * t))))
    run = ancf.quasi_static(scene, t_end, t_end / steps)
    truth = distance_from_shorter_steps(run, beam.end, scene, beam.end, 50)
    close(inertia_error(run, ancf.position(beam.end)), truth)


@pytest.mark.parametrize("twist", [0.1, 1.0])
def test_torsion_of_a_moment_along_the_axis(twist):
    """Its energy beside that of bending, as the thick beam has them."""

    def bent(element, n):
        scene, beam = build_beam(
            element, (0, 0, 0), (1, 0, 0), n, ancf.Circle(0.01), ancf.Material(2e9, 1000.0),
            "clamp", gravity=(0.0, 0.0, 0.0),
        )  # fmt: skip
        scene.point_moment(beam.end, ancf.Ramp((0.05 * twist, 0.0, 0.05), 1.0))
        return scene, beam

    scene, beam = bent("thin", 8)
    run = ancf.quasi_static(scene, 1.0, 0.5)
    size = np.linalg.norm(run.position(beam.end)[-1] - beam.end.position)
    share = neglected_effects(run, ancf.position(beam.end))["torsion"] / size
    rich, other = bent("thick", 16)
    force = ancf.quasi_static(rich, 1.0, 0.5).section_force(other)
    given = other.stiffnesses()
    truth = np.sum(force.T[-1] ** 2) / given["torsion_stiffness"]
    truth /= np.sum(force.M[-1] ** 2) / given["bending_stiffness_z"]
    close(share, truth)


def test_torsion_between_two_clamps_that_are_turned_against_each_other():
    """A frame carried along a cable that leaves its plane is turned at the end; in a plane not.

    The angle is the solid angle that the tangent goes round on the sphere.
    """
    from ancfsparse.plans.model_error.section_energies import transported_angle

    scene = ancf.Scene(gravity=(0.0, 0.0, 0.0))
    beam = scene.add_beam(
        "thin", (0, 0, 0), (1, 0, 0), 4, ancf.Circle(0.01), ancf.Material(1e9, 1e3)
    )
    angle = np.linspace(0.0, 2.0 * np.pi, 2001)
    flat = np.stack([np.cos(0.3 * np.sin(angle)), np.sin(0.3 * np.sin(angle)), 0 * angle], axis=1)
    np.testing.assert_allclose(transported_angle(flat[None], beam), 0.0, atol=1e-12)
    # A circle on the sphere through e_x, with the half angle 0.3 about a tilted axis.
    axis = np.array([np.cos(0.3), np.sin(0.3), 0.0])
    other = np.array([-np.sin(0.3), np.cos(0.3), 0.0])
    around = np.cos(angle)[:, None] * -other + np.sin(angle)[:, None] * np.array([0.0, 0.0, 1.0])
    cone = np.cos(0.3) * axis + np.sin(0.3) * around
    solid = 2.0 * np.pi * (1.0 - np.cos(0.3))
    assert abs(transported_angle(cone[None], beam)[0]) == pytest.approx(solid, rel=1e-5)


def test_what_a_model_has_is_left_out_and_nothing_where_nothing_acts():
    made = ancf.Rectangle(0.01, 0.01), ancf.Material(2e9, 1000.0)
    scene, beam = build_beam("thick", (0, 0), (1, 0), 4, *made, "clamp", gravity=(0.0, 0.0))
    run = ancf.simulate(scene, 0.01, dt=1e-3)
    assert neglected_effects(run, ancf.position(beam.end)) == {}
    still, beam = build_beam("thin", (0, 0), (1, 0), 4, *made, "clamp", gravity=(0.0, 0.0))
    run = ancf.quasi_static(still, 1.0, 0.5)
    error_model = neglected_effects(run, ancf.position(beam.end))
    assert set(error_model) == {"shear", "stretch"}
    assert not any(error_model.values())
