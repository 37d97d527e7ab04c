"""Legs' waves: parts of their estimate, none of it where legs are still, and elements for a known frequency."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import Ends, smooth_trip, wound

from rope_model import Mesh, Rope, Scene
from rope_model.engine import NativeRope
from rope_model.method import leg_waves
from rope_model.method.leg_waves import ElementWave, LegsMotion, LegWaves
from rope_model.method.mesh_fit import SHAKEN_ELEMENTS, shaken_length
from rope_model.method.step_errors import end_force_error
from rope_model.physics.estimates import axial_frequency, bending_length
from rope_model.reference.mesh import mesh_of

SCENE = Scene(rope=Rope(length=60.0))


@pytest.mark.parametrize("length", [60.0, 120.0, 430.0, 1000.0])
@pytest.mark.parametrize("frequency", [1.0, 5.0])
def test_waves_of_the_lateral_frequency_have_five_elements_all_along_the_legs(
    length: float, frequency: float
) -> None:
    scene = Scene(Rope(length=length), mesh=Mesh("auto", lateral_frequency=frequency))
    bottom = 0.6 * length
    lengths = mesh_of(scene, bottom).lengths
    height = np.abs(np.cumsum(lengths) - 0.5 * lengths - bottom)
    leg = height > 2.0 * bending_length(scene)
    waves = SHAKEN_ELEMENTS * np.array([shaken_length(scene, y) for y in height[leg]])
    # the pattern's element may be some percent longer than asked, so that whole ones fit
    assert (waves / lengths[leg]).min() > 0.9 * SHAKEN_ELEMENTS


def test_without_a_lateral_frequency_the_mesh_is_that_of_the_loop() -> None:
    plain, none = (
        mesh_of(SCENE.with_(mesh=mesh), 30.0).lengths
        for mesh in (Mesh("auto"), Mesh("auto", lateral_frequency=1e-3))
    )
    assert_allclose(plain, none, rtol=0)


def wave_error(rope: NativeRope) -> float:
    """Part of the end forces' estimate that waves of the legs have."""
    state = rope.state
    return float(leg_waves.leg_force_error(rope.scene, state.waves, state.errors))


def winding(t: float) -> Ends:
    """Both ends pass each other within 8 s."""
    return smooth_trip(t, 30.0, 8.0, 30.0)


def test_legs_at_rest_and_in_a_smooth_winding_have_no_waves_to_estimate() -> None:
    rope = wound(NativeRope(SCENE), lambda _: winding(0.0), 10, 0.01)
    assert wave_error(rope) < 1e-9
    rope = wound(NativeRope(SCENE), winding, 1000, 0.01)
    state = rope.state
    assert state.counts.transformations > 3
    assert wave_error(rope) < float(end_force_error(rope.scene.rope, state.errors))
    assert leg_waves.leg_loop_error(rope.scene, state.waves, state.errors.time) < 1e-4
    assert "unresolved_waves" not in rope.warnings()


#: an element of a leg, 3 m long, 20 m above the loop
LENGTH = 3.0
HEIGHT = 20.0
BEGINS = leg_waves.leg_begins(SCENE)
#: coordinates and rates of its ends, and x' = m + c1 P1 + c2 P2 by both
Q = np.array([0.01, 0.0, 0.0, 0.002, -1.0, 0.0, 0.0, 0.013, -3.0, 0.0, -0.001, -1.0, 0.0, 0.0])
V = np.array([0.1, 0.0, 0.0, 0.03, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0, -0.05, 0.0, 0.0, 0.0])


def slope(row: np.ndarray, xi: np.ndarray) -> np.ndarray:
    """x' of the cubic with these ends at xi from 0 to 1, by its derivative in xi."""
    x, d, y, e = row[0], LENGTH * row[3], row[7], LENGTH * row[10]
    rate = (6 * xi**2 - 6 * xi) * (x - y) + (3 * xi**2 - 4 * xi + 1) * d + (3 * xi**2 - 2 * xi) * e
    return np.asarray(rate / LENGTH)


def test_an_element_takes_the_length_off_its_leg_that_its_cubic_has() -> None:
    points, weights = np.polynomial.legendre.leggauss(6)
    xi = 0.5 * (1 + points)
    wave = leg_waves.element_wave(SCENE, Q, V, V, LENGTH, HEIGHT, BEGINS)
    by_points = 0.5 * LENGTH * np.sum(weights * slope(Q, xi) * slope(V, xi))
    assert_allclose(wave.shortening, by_points, rtol=1e-12)
    by_points = 0.5 * LENGTH * np.sum(weights * slope(V, xi) ** 2)
    assert_allclose(wave.slopes, by_points, rtol=1e-12)


def resolved(k: float) -> ElementWave:
    """An element's part of a wave of the wave number k (1/m) whose slope vanishes in its middle."""
    row = np.zeros(14)
    half = 0.5 * k * LENGTH
    row[0] = -math.sin(half) / k
    row[7] = math.sin(half) / k
    row[3] = row[10] = math.cos(half)
    return leg_waves.element_wave(SCENE, row, row, row, LENGTH, HEIGHT, BEGINS)


def test_the_short_part_of_a_resolved_wave_is_the_fourth_power_of_its_elements() -> None:
    for k in (0.1, 0.2):
        wave = resolved(k)
        assert_allclose(wave.bent / wave.slopes, (k * LENGTH) ** 4 / 720.0, rtol=0.1)


def responded(frequency: float, leg: float, amplitude: float, lasting: float) -> float:
    """Root mean square of the end force (N) by a rate of shortening of the left leg."""
    h = 2e-4
    waves = LegWaves()
    still = LegsMotion(leg, (0.0, 0.0), (0.0, 0.0), *(0.0,) * 9)
    for k in range(round(lasting / h)):
        rate = amplitude * math.sin(2 * math.pi * frequency * k * h)
        legs = still._replace(shortening=(rate, 0.0))
        waves = leg_waves.add_leg_waves(SCENE, waves, legs, h, 0.0)
    return math.sqrt(waves.left_all.square / lasting)


def test_a_fast_shortening_meets_the_impedance_of_the_rope() -> None:
    leg = 30.0
    first = axial_frequency(SCENE.rope, leg) / (2 * math.pi)
    force = responded(12.3 * first, leg, 1e-3, 0.5)
    impedance = math.sqrt(SCENE.rope.Qa * SCENE.rope.mass_per_length)
    assert_allclose(force, impedance * 1e-3 / math.sqrt(2), rtol=0.05)


def test_a_shortening_at_the_legs_frequency_resonates_and_a_slow_one_hardly_acts() -> None:
    leg = 30.0
    rope = SCENE.rope
    omega = axial_frequency(rope, leg)
    first = omega / (2 * math.pi)
    # 2 zeta = beta_K omega; the uniform strain has 4 / pi of the slowest wave
    resonant = leg_waves.UNIFORM * rope.Qa * 1e-3 / leg / (rope.beta_K * omega**2)
    assert_allclose(responded(first, leg, 1e-3, 2.0), resonant / math.sqrt(2), rtol=0.15)
    assert responded(first / 10, leg, 1e-3, 2.0) < 0.05 * resonant
