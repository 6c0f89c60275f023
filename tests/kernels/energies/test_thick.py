"""Relations between the forms of the thick beam."""

import numpy as np
import pytest

from tests.kernels.bench import VALUES
from tests.kernels.states import STATES, straight

FORMS = [f"{c}_{s}" for c in ("axis", "section") for s in ("consistent", "nodal")]


@pytest.mark.parametrize("state", STATES)
def test_closed_form_is_exact_quadrature(state, bench, rng):
    closed, quadrature = bench("thick_axis_consistent"), bench("thick_axis_consistent_gauss")
    q = np.array([STATES[state](closed.labels, VALUES["length"], rng) for _ in range(9)])
    for kernel in ("energy", "force"):
        expected = quadrature.run(kernel, q)
        assert np.abs(closed.run(kernel, q) - expected).max() <= 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("form", FORMS)
def test_stretched_bar_without_stress_across_has_youngs_modulus(form, bench):
    """eps_y = eps_z = -nu eps_x leaves E A eps_x^2 / 2: Poisson's effect is free in both forms."""
    element = bench(f"thick_{form}")
    nu, shear = VALUES["poisson_ratio"], VALUES["shear_modulus_area"]
    lam, youngs = 2 * shear * nu / (1 - 2 * nu), 2 * shear * (1 + nu)
    values = VALUES | {"lame_area": lam, "youngs_modulus_area": youngs}
    eps = 0.01
    q = straight(element.labels, VALUES["length"])
    for i, label in enumerate(element.labels * 2):
        along = label.startswith("r_x") or label == "r_1"
        q[i] *= np.sqrt(1 + 2 * eps) if along else np.sqrt(1 - 2 * nu * eps)
    base = np.array([[values[p] for p in element.kind.parameters]])
    expected = youngs * VALUES["length"] * eps**2 / 2
    assert element.run("energy", q, base=base)[0, 0] == pytest.approx(expected, rel=1e-12)


def test_nodal_section_strain_does_not_punish_an_angle_between_nodes(bench):
    """A bent element whose nodes are free of section strain: only the consistent form resists."""
    nu, shear = VALUES["poisson_ratio"], VALUES["shear_modulus_area"]
    stiff = {"lame_area": 2 * shear * nu / (1 - 2 * nu), "shear_modulus_area": shear}
    stiff |= {"youngs_modulus_area": 2 * shear * (1 + nu), "poisson_ratio": nu, "length": 1.0}
    angle = 0.2
    c, s = np.cos(angle / 2), np.sin(angle / 2)
    radius = 1 / angle
    start = [-radius * s, 0, 0, c, s, 0, -s, c, 0, 0, 0, 1]
    end = [radius * s, 0, 0, c, -s, 0, s, c, 0, 0, 0, 1]
    energies = {}
    for form in ("consistent", "nodal"):
        element = bench(f"thick_axis_{form}")
        base = np.array([[stiff.get(p, 0.0) for p in element.kind.parameters]])
        energies[form] = element.run("energy", start + end, base=base)[0, 0]
    assert energies["nodal"] < 1e-3 * energies["consistent"]
