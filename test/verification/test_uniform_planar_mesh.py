# Copyright 2026 squeal_ros developers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
The planar-mesh method on K09's brake: as printed, and as it should be.

Expected errors are those of the rules themselves, exact shapes being put in the place of
interpolated ones.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from types import ModuleType
from typing import Any, TypeAlias

import numpy as np
import pytest
from squeal_core.brake.dimensions import Brake
from squeal_core.common.arrays import FloatArray
from squeal_core.model import operators
from squeal_core.modes.fe.axisymmetric import HarmonicModes
from squeal_core.modes.fe.solid import SolidModes
from squeal_core.modes.planar_mesh import (
    AS_PRINTED,
    contact_grid,
    LayeredBasis,
    PlanarGrid,
    PlanarModes,
)
from squeal_core.stability.eigenvectors import mode_vectors

Grid: TypeAlias = Callable[..., dict[str, FloatArray]]


@pytest.fixture(scope='session')
def exact(example: ModuleType, brake: Brake, disc: HarmonicModes,
          pad: SolidModes) -> dict[str, FloatArray]:
    """Arrays of the shipped model's modes without any planar mesh."""
    return example.exact_arrays(  # type: ignore[no-any-return]
        brake, disc, pad, panels=(9, 18))


@pytest.fixture(scope='session')
def on_grid(example: ModuleType, brake: Brake, disc: HarmonicModes,
            pad: SolidModes) -> Grid:
    """Return what gives contact arrays of exact shapes on a grid, each once."""
    @cache
    def arrays(contact: tuple[int, int], **settings: Any) -> dict[str, FloatArray]:
        grid = PlanarGrid(**{'radial': 4, 'around': 24, 'contact': contact,
                             'derivative': 'local', **settings})
        half = 0.5 * brake.disc.rotor_thickness
        planar = PlanarModes(LayeredBasis(disc, example.hat_layers(brake.disc, 1)), grid)
        both = example.faces(brake, [planar.sample(contact_grid(brake.contact, z, grid))
                                     for z in (half, -half)], pad)
        return {name: function(both) for name, (_, function) in example.ARRAYS.items()}

    return arrays


# ---------------------------------------------------------------- as printed

def test_forward_differences_shrink_the_gyroscopic_matrix(
        example: ModuleType, brake: Brake, disc: HarmonicModes) -> None:
    """By sin(n d) / (n d) in what they differentiate, not in the turning of the base vectors."""
    layers, d = example.hat_layers(brake.disc, 1), PlanarGrid(around=48).step
    grid = PlanarGrid(radial=4, around=48, derivative='local')
    plain = PlanarModes(LayeredBasis(disc, layers), grid)
    rho = disc.density
    whole = operators.gyroscopic(plain.volume_layers(), rho)
    turning = sum(rho * ((s.tangential * s.points.weight) @ s.radial.T
                         - (s.radial * s.points.weight) @ s.tangential.T)
                  for s in plain.volume_layers())
    turning = turning - turning.T
    n = np.array([mode.diameters for mode in disc.section_modes])
    for derivative in ('forward', 'central'):
        found = operators.gyroscopic(
            replace(plain, grid=replace(grid, derivative=derivative)).volume_layers(), rho)
        expected = np.sinc(n * d / np.pi) * (whole - turning) + turning
        assert np.abs(found - expected).max() < 1e-10 * np.abs(whole).max()
    shrunk = np.sinc(9 * d / np.pi)
    assert shrunk == pytest.approx(0.785, abs=1e-3)  # a fifth is lost of nine diameters


def test_sums_over_nodes_are_a_quarter_too_high(
        example: ModuleType, on_grid: Grid, exact: dict[str, FloatArray]) -> None:
    """15 x 43 nodes, the edges with full weight: contact stiffness 26 % too high."""
    found = on_grid(AS_PRINTED.contact, rule='nodes')
    off = example.errors(found, {name: exact[name] for name in found})
    assert off['A0'] == pytest.approx(0.257, abs=0.005)
    assert {name: round(e, 2) for name, e in off.items()} == {
        'A0': 0.26, 'B0': 0.21, 'R0': 0.13, 'S0': 0.15, 'F0': 0.1}
    lift = 3  # the same at all points, so its entry is the area's: 15/14 times 43/42
    assert found['A0'][lift, lift] / exact['A0'][lift, lift] == pytest.approx(
        15 / 14 * 43 / 42, rel=1e-6)


def test_printed_sums_make_the_pads_squeal(
        example: ModuleType, brake: Brake, disc: HarmonicModes, pad: SolidModes,
        on_grid: Grid, exact: dict[str, FloatArray]) -> None:
    """11 1/s are the pad pair's; 154 come of 15 x 43 nodes, and 187 of 20 x 57."""
    point, count, growth = example.operating_point(brake), len(pad.names), []
    for found in (exact, *(exact | on_grid(contact, rule='nodes')
                           for contact in ((15, 43), (20, 57)))):
        worst = example.unstable(brake, disc, pad, found)[0]
        growth.append(worst.growth_rate)
        energy = np.abs(mode_vectors(example.model(brake, disc, pad, found), point,
                                     worst.eigenvalue).right)**2
        assert energy[count:-count].sum() < 0.1 * energy.sum()  # little of it is the disc's
        assert 3100.0 < worst.frequency_hz < 3400.0
    assert growth == pytest.approx([11.0, 154.4, 187.3], abs=0.5)


@pytest.mark.parametrize(('derivative', 'order'), [('forward', 1.0), ('central', 2.0)])
def test_differences_in_the_follower(derivative: str, order: float, example: ModuleType,
                                     on_grid: Grid, exact: dict[str, FloatArray]) -> None:
    """F0 has no skew part that forward differences could be right in: n d / 2 remain."""
    off = [example.errors(on_grid((36, 72), around=around,
                                  derivative=derivative), {'F0': exact['F0']})['F0']
           for around in (122, 244)]
    assert np.log2(off[0] / off[1]) == pytest.approx(order, abs=0.02)
    assert off[1] == pytest.approx({'forward': 6.2e-2, 'central': 3.2e-3}[derivative], rel=0.02)


# ---------------------------------------------------------------- as it should be

@pytest.mark.parametrize(('rule', 'order', 'ladder'), [
    ('nodes', 1.0, ((8, 22), (15, 43), (29, 85))),
    ('midpoint', 2.0, ((7, 21), (14, 42), (28, 84)))])
def test_contact_arrays_converge(rule: Any, order: float, ladder: tuple[tuple[int, int], ...],
                                 example: ModuleType, on_grid: Grid,
                                 exact: dict[str, FloatArray]) -> None:
    """Sums over nodes with h, over cells with h^2: every array, under halving of the grid."""
    off = [example.errors(on_grid(contact, rule=rule),
                          {name: exact[name] for name in example.ARRAYS}) for contact in ladder]
    for name in example.ARRAYS:
        values = np.array([row[name] for row in off])
        rates = np.log2(values[:-1] / values[1:])
        # two edges meet in corners, whose h^2 still counts for 8 nodes
        assert rates[-1] == pytest.approx(order, abs=0.1), name
        assert abs(rates[-1] - order) <= abs(rates[0] - order) + 0.02, name


def test_gauss_rule_is_exact_at_once(example: ModuleType, brake: Brake, disc: HarmonicModes,
                                     pad: SolidModes, exact: dict[str, FloatArray]) -> None:
    found = example.grid_arrays(brake, disc, pad, PlanarGrid(), 3)
    off = example.errors(found, exact)
    assert max(off[name] for name in example.ARRAYS) < 1e-6
    assert off['G0'] < 4e-4  # what re-entrant corners leave
    assert example.largest_growth(brake, disc, pad, found) == pytest.approx(
        example.largest_growth(brake, disc, pad, exact), abs=1e-2)


@pytest.mark.parametrize(('rule', 'derivative', 'order'), [
    ('nodes', 'forward', 1.0), ('midpoint', 'central', 2.0)])
def test_gyroscopic_matrix_converges(rule: Any, derivative: Any, order: float,
                                     example: ModuleType, brake: Brake,
                                     disc: HarmonicModes) -> None:
    """Low modes, all three directions refined together."""
    low = replace(disc, section_modes=disc.section_modes[:13])
    exact = operators.gyroscopic(low.volume_layers(), low.density)
    off = []
    for n in (1, 2, 4):
        modes = PlanarModes(LayeredBasis(low, example.hat_layers(brake.disc, 2 * n)), PlanarGrid(
            radial=10 * n, around=48 * n, rule=rule, derivative=derivative))
        found = operators.gyroscopic(modes.volume_layers(), low.density)
        off.append(np.linalg.norm(found - exact) / np.linalg.norm(exact))
    rates = np.log2(np.divide(off[:-1], off[1:]))
    assert rates == pytest.approx(order, abs=0.15), rates
