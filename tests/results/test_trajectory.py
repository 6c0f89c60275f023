"""Results read the vectors of a system by the names of the scene."""

import numpy as np
import pytest

from ancfsparse.results import Equilibrium, RunStats, Trajectory


def test_motion_of_points(trajectory):
    rod, t = trajectory.system.rod, trajectory.t
    flight = np.column_stack([3.0 * t + t**2, -0.5 * 9.81 * t**2])
    for point in (rod.start, rod.node(2), rod.at(1.3), rod.end):
        np.testing.assert_allclose(trajectory.position(point), flight + point.position, atol=1e-12)
        np.testing.assert_allclose(
            trajectory.velocity(point), np.column_stack([3.0 + 2.0 * t, -9.81 * t]), atol=1e-12
        )
        np.testing.assert_allclose(trajectory.acceleration(point), [[2.0, -9.81]] * 9, atol=1e-12)
        np.testing.assert_allclose(trajectory.slope(point), [[1.0, 0.0]] * 9, atol=1e-12)


def test_energy_balance_of_a_thrown_mass(trajectory):
    energy, t = trajectory.energy, trajectory.t
    np.testing.assert_allclose(energy.kinetic, 0.5 * ((3 + 2 * t) ** 2 + (9.81 * t) ** 2))
    np.testing.assert_allclose(energy.elastic, 0.25)
    np.testing.assert_allclose(energy.potential, -0.5 * 9.81**2 * t**2, atol=1e-12)
    # A force of 2 N does the work 2 (x(t) - x(0)); its power is linear in t, so the sum is exact.
    np.testing.assert_allclose(energy.work, 2.0 * (3.0 * t + t**2), atol=1e-12)
    np.testing.assert_allclose(energy.total, energy.kinetic + energy.elastic + energy.potential)
    assert energy.drift < 1e-14
    assert trajectory.energy is energy
    assert "work 2.72 J, dissipated 0 J, drift" in repr(energy)


def test_drift_is_the_defect_over_the_largest_kinetic_energy(trajectory):
    # Freezing the mass in place keeps its kinetic energy and takes away the other two changes.
    frozen = np.tile(trajectory.q[0], (9, 1))
    stuck = Trajectory(trajectory.system, trajectory.t, frozen, trajectory.v, trajectory.a,
                       trajectory.lam, trajectory.stats)  # fmt: skip
    kinetic = stuck.energy.kinetic
    defect = np.abs(kinetic - kinetic[0] - stuck.energy.work).max()
    assert stuck.energy.drift == pytest.approx(defect / kinetic.max())
    assert stuck.energy.drift > 0.1


def test_dissipated_energy_is_the_power_of_damping_summed_to_second_order(trajectory):
    trajectory.system.drag = 0.7
    errors = []
    for every in (4, 2, 1):
        kept = slice(None, None, every)
        run = Trajectory(trajectory.system, trajectory.t[kept], trajectory.q[kept],
                         trajectory.v[kept], trajectory.a[kept], trajectory.lam[kept],
                         trajectory.stats)  # fmt: skip
        t, energy = run.t, run.energy
        exact = 0.7 * (9 * t + 6 * t**2 + (4 + 9.81**2) * t**3 / 3)
        errors.append(np.abs(energy.dissipated - exact).max())
        # Nothing was taken from this flight, so all of it is missing from the balance.
        assert energy.drift == pytest.approx(energy.dissipated[-1] / energy.kinetic.max())
    assert errors[-1] < 0.02 * exact[-1]
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4.0, rtol=1e-6)


def test_nothing_that_moves_does_not_drift(trajectory):
    rest = np.zeros_like(trajectory.v)
    still = Trajectory(trajectory.system, trajectory.t, trajectory.q[:1].repeat(9, axis=0), rest,
                       rest, trajectory.lam, trajectory.stats)  # fmt: skip
    assert still.energy.drift == 0.0


def test_reactions_and_the_rest(trajectory):
    rod = trajectory.system.rod
    expected = np.array([3.0, -4.81]) + trajectory.t[:, None]
    np.testing.assert_allclose(trajectory.reaction(rod.start), expected, atol=1e-12)
    assert trajectory.multipliers is trajectory.lam
    assert trajectory.settings == {"dt": 0.05}
    assert repr(trajectory) == (
        "Trajectory: 9 states from t = 0 s to 0.4 s, 20 coordinates, 2 multipliers\n"
        "  8 steps, 2.50 iterations per step, 1 factorizations, 0.002 s, newton"
    )


def test_equilibrium(system):
    rod = system.rod
    lam = np.array([7.0, 8.0])
    rest = Equilibrium(system, system.state(np.pi / 2), lam, RunStats(steps=3, iterations=9))
    np.testing.assert_allclose(rest.position(rod.end), [0.0, 2.0], atol=1e-9)
    np.testing.assert_allclose(rest.displacement(rod.end), [-2.0, 2.0], atol=1e-9)
    np.testing.assert_allclose(rest.displacement(rod.at(0.3)), [-0.3, 0.3], atol=1e-9)
    np.testing.assert_allclose(rest.slope(rod.at(0.3)), [0.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(rest.reaction(rod.start), [7.0, 8.0])
    assert rest.multipliers is lam
    assert rest.elastic_energy == 0.25
    assert repr(rest) == "Equilibrium: 20 coordinates, 2 multipliers, 3 load steps, 9 iterations"


def test_stats_per_step():
    assert RunStats(steps=4, iterations=10).iterations_per_step == 2.5
    assert RunStats().iterations_per_step == 0.0
    assert RunStats().seconds == {}


def test_stats_that_were_not_estimated_are_equal():
    def stats(contraction):
        return RunStats(error=float("nan"), events=[(1, 0.1, "new seed", "diverged", contraction)])

    assert stats(float("nan")) == stats(float("nan"))
    assert stats(0.5) == stats(0.5) != stats(0.6)
    assert stats(0.5) != stats(float("nan"))
    assert RunStats(error=1e-3) != RunStats() != "stats"
