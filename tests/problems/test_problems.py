"""The named scenes are what the paper and the benchmarks say."""

import math

import numpy as np
import pytest

from ancfsparse.errors import InputError
from ancfsparse.problems import cantilever, elastica, pendulum, roll_up
from ancfsparse.scene import Clamp, Pin


def test_the_papers_pendulum():
    scene, rod = pendulum()
    parameters = rod.parameters()
    np.testing.assert_array_equal(scene.gravity, [0.0, -9.81])
    assert (rod.element, rod.n_elements, rod.length) == ("thin", 10, 2.0)
    np.testing.assert_array_equal(rod.positions[[0, -1]], [[0.0, 0.0], [2.0, 0.0]])
    assert parameters["axial_stiffness"] == pytest.approx(1e8 * 1e-4)
    assert parameters["mass_per_length"] == pytest.approx(4000 * 1e-4)
    assert rod.velocity is None
    (pin,) = scene.joints
    assert isinstance(pin, Pin)
    assert pin.node == rod.start
    assert not pin.as_constraint
    assert scene.loads == []


def test_pendulum_variants():
    assert pendulum("l2t2").scene.dim == 2
    assert pendulum("thick").scene.dim == 3
    assert pendulum("thick", dim=2, section_strain="nodal").rod.options["section_strain"] == "nodal"
    np.testing.assert_array_equal(pendulum("thin", dim=3).scene.gravity, [0.0, -9.81, 0.0])
    assert pendulum(strain="biot").rod.options == {"strain": "biot"}
    changed = pendulum(n_elements=4, nu=0.0, youngs_modulus=2e8, as_constraint=True)
    assert changed.rod.material.poisson_ratio == 0.0
    assert changed.rod.material.youngs_modulus == 2e8
    assert changed.scene.joints[0].as_constraint
    with pytest.raises(InputError, match=r"dim must be 2 \(planar\) or 3 \(spatial\), got 4"):
        pendulum(dim=4)
    with pytest.raises(InputError, match="unknown element 'thik': did you mean 'thick'"):
        pendulum("thik")


@pytest.mark.parametrize("dim", [2, 3])
def test_cantilever_of_gerstmayr_and_irschik(dim):
    # F = 3 E I / L^2 with E = 2.07e11, I = 0.1^4/12, L = 2: 1293750 N.
    scene, rod = cantilever(dim=dim)
    np.testing.assert_allclose(scene.loads[0].at(0.0)[:2], [0.0, -1293750.0])
    assert scene.loads[0].node == rod.end
    assert not scene.gravity.any()
    assert isinstance(scene.joints[0], Clamp)
    assert scene.joints[0].stretch == "free"


def test_elastica_is_as_slender_as_asked():
    scene, rod = elastica(load=10.0, slenderness=500.0)
    parameters = rod.parameters()
    stiffness = parameters["bending_stiffness"] / rod.length**2
    assert parameters["axial_stiffness"] / stiffness == pytest.approx(500.0**2)
    assert -scene.loads[0].at(0.0)[1] / stiffness == pytest.approx(10.0)
    with pytest.raises(InputError, match="slenderness must be positive, got 0"):
        elastica(slenderness=0.0)


def test_roll_up_closes_one_turn():
    # M = 2 pi E I / L.
    expected = 2 * math.pi * 2.07e11 * 0.1**4 / 12 / 2.0
    np.testing.assert_allclose(roll_up().scene.loads[0].at(0.0), [expected])
    spatial = roll_up("thin", dim=3, turns=0.5)
    np.testing.assert_allclose(spatial.scene.loads[0].at(0.0), [0.0, 0.0, expected / 2])
