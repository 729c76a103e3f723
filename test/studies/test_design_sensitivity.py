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

"""What to change on a brake: derivatives against closed forms, differences and other builds."""

from dataclasses import replace
from functools import partial
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel, build_model, complex_modes, critical_value, OperatingPoint
from squeal_core.assembly.parts import PartCache
from squeal_core.assembly.variants import BrakeVariants
from squeal_core.brake.brake_yaml import parse_brake
from squeal_core.brake.design_parameters import design_parameters, scaled
from squeal_core.brake.dimensions import Contact, Material, Pad
from squeal_core.model.affine_variants import AffineVariants
from squeal_core.model.change_of_basis import in_basis
from squeal_core.modes.fe.solid import pad_modes
from squeal_core.risk.ensemble import EnsemblePrior, prior_ensemble
from squeal_core.risk.steady_braking import SteadyBraking
from squeal_core.stability.mode_tracking import Identity
from squeal_core.studies.design_sensitivity import make_study, SensitivityStudy
from squeal_core.studies.led_doublet import led_doublet
from squeal_core.studies.split_doublet import DiscRing, ModeOverAngle, SplitDoublet
from squeal_core.studies.worst_points import worst_points
from support.brake_descriptions import edited
from support.commands import squeal

COARSE: dict[str, Any] = {'disc_order': 2, 'pad_elements': (3, 6, 1), 'contact_points': 3}
PARTS = PartCache()  # a part that did not change is solved once for all builds
CONTENT = edited({'modes.disc': 10, 'modes.pad': 8})
COUPLED = [[0.0, 1e-3], [-1e-3, 0.0]]
PAIR = BrakeModel(angular_frequencies=[1e4, 1.02e4], damping_ratios=0.002,
                  friction_couple=COUPLED)
AT = OperatingPoint(rotor_speed=7.0, friction=0.3, contact_pressure=5e5, contact_stiffness=1e10)
BAND = (1000.0, 16000.0)


def driven(model: BrakeModel) -> OperatingPoint:
    return model.operating_point(rotor_speed=5.0, pressure=8e5, friction=0.5)


def of_pair(model: BrakeModel) -> OperatingPoint:
    return OperatingPoint(rotor_speed=7.0, friction=0.3, contact_pressure=5e5,
                          contact_stiffness=model.nominal_contact_stiffness)


@pytest.fixture(scope='module')
def variants() -> BrakeVariants:
    """Return variants of a coarse brake, built once."""
    build = partial(build_model, parts=PARTS, audit=False, **COARSE)
    return BrakeVariants(build(parse_brake(CONTENT)), CONTENT, Path(), build)


@pytest.fixture(scope='module')
def study(variants: BrakeVariants) -> SensitivityStudy:
    return make_study(variants, [driven], [()], with_risk=False, band_hz=BAND)


def rebuilt(path: str, factor: float) -> BrakeModel:
    """Return a model that is built with nothing but the changed description."""
    return build_model(parse_brake(scaled(CONTENT, path, factor)), parts=PARTS, audit=False,
                       **COARSE)


@pytest.mark.parametrize('path', ['disc.young_modulus_gpa', 'pads.density_kg_m3'])
def test_materials_scale_exactly(variants: BrakeVariants, path: str) -> None:
    """Modes of a part go with (E/rho)^1/2: eigenvalues as of a brake that is built anew."""
    assert variants.affine(path)
    pairs = [np.sort_complex(complex_modes(model, driven(model)).oscillatory)
             for model in (variants(path, 1.1), rebuilt(path, 1.1))]
    np.testing.assert_allclose(*pairs, rtol=1e-7)  # of two eigensolutions of the parts


@pytest.mark.parametrize('path', ['disc.rotor_thickness_mm', 'contact.angle_deg',
                                  'friction.static', 'contact.stiffness_n_m3'])
def test_derivatives_are_those_of_other_builds(study: SensitivityStudy, path: str) -> None:
    """Central differences over +-1 % of models in their own coordinates, nearest eigenvalue."""
    effect = study.effect(path)
    own, root = effect.modes[0], study.targets[0].eigenvalue
    found = []
    for factor in (1.01, 0.99):
        model = rebuilt(path, factor)
        roots = complex_modes(model, driven(model)).oscillatory
        found.append(roots[np.abs(roots - root).argmin()])
    difference = 0.5 * (found[0] - found[1])
    # second order in 1 %: thirds of a per cent of a slope that bends as a cube
    assert own.growth_rate == pytest.approx(difference.real, rel=0.02, abs=1e-3)
    assert own.frequency_hz == pytest.approx(difference.imag / math.tau, rel=0.01, abs=1e-3)
    assert own.error <= 0.02 * abs(own.growth_rate) + 1e-3
    assert study.variants.affine(path) == (path[:4] in ('fric', 'cont') and 'angle' not in path)


def test_thin_pads_bend_as_their_thickness() -> None:
    """First bending of a free plate: f ~ h sqrt(E/rho)."""
    contact = Contact(inner_radius=0.1, outer_radius=0.142, angle=np.deg2rad(62.0), stiffness=1e10)
    steel = Material(207e9, 7820.0, 0.29)
    thin, thicker = (pad_modes(Pad(steel, h), contact, 7, elements=(4, 10, 1)).
                     angular_frequencies[6] for h in (1.0e-3, 1.01e-3))
    assert math.log(thicker / thin) / math.log(1.01) == pytest.approx(1.0, abs=0.01)


def test_critical_friction_of_two_modes() -> None:
    """The product mu k_c couples the two: mu falls by one per cent where k_c rises by one."""
    study = make_study(AffineVariants(PAIR), [of_pair], [()], with_risk=False)
    target = study.targets[0]
    assert target.critical_friction == pytest.approx(
        critical_value(PAIR, of_pair(PAIR), 'friction', (0.0, 1.0)).nearest.value, rel=1e-4)
    effect = study.effect('contact.stiffness')
    assert effect.modes[0].critical_friction == pytest.approx(
        -0.01 * target.critical_friction, rel=1e-4)
    # more damping of all modes alike: growth falls by 2 xi w / 2 of the mean frequency per unit
    assert study.effect('damping_ratio').modes[0].growth_rate == pytest.approx(
        -0.01 * 0.002 * 1.01e4, rel=1e-3)


def test_change_of_the_risk() -> None:
    """As that of two models 1 % apart whose members are each solved in full."""
    ensemble = prior_ensemble(EnsemblePrior(count=32))
    study = make_study(AffineVariants(PAIR), [of_pair], [()], prior=EnsemblePrior(count=32))
    for path in ('damping_ratio', 'contact.stiffness'):
        risks = [SteadyBraking(model, of_pair(model), ensemble, 3.0).risk for model in (
            study.variants(path, 1.01), study.variants(path, 0.99))]
        assert study.effect(path).risk[0] == pytest.approx(
            0.5 * (risks[0] - risks[1]), rel=0.1, abs=1e-4)
    assert 0.0 < study.risks()[0] < 1.0


def test_a_more_damped_member_is_a_nominal_one_of_a_more_damped_brake() -> None:
    """Also in what noise brings, for its floor is held by more."""
    nominal = prior_ensemble(EnsemblePrior(count=32, damping=0.0))
    twice = replace(nominal, ln_damping=np.full(32, np.log(2.0)))
    damped = replace(PAIR, damping_ratios=0.004)
    member, brake, less = (
        SteadyBraking(model, of_pair(model), ensemble, 0.01, BAND).risk for model, ensemble in (
            (PAIR, twice), (damped, nominal), (PAIR, nominal)))
    assert 0.1 < member < 0.95 * less < 0.9
    assert member == pytest.approx(brake, rel=1e-9)  # the same numbers but for rounding


def test_values_that_cannot_be_are_named(study: SensitivityStudy) -> None:
    """An efficiency above one: the rest goes on."""
    effect = study.effect('caliper.efficiency')
    assert not effect.modes
    assert 'caliper.efficiency' in effect.reason


def test_solvers_that_fail_cost_one_parameter(study: SensitivityStudy) -> None:
    """As scikit-fem's ValueError of a mesh that is none: not known, with the reason."""
    def build(_: object) -> BrakeModel:
        raise ValueError('Point is outside\nof the mesh')

    failing = replace(study, variants=BrakeVariants(study.variants.model, CONTENT, Path(), build))
    lost, known = failing.effects(['disc.hat_height_mm', 'friction.static'])
    assert lost.reason == 'cannot be computed (ValueError: Point is outside of the mesh)'
    assert (known.reason, len(known.modes)) == ('', 1)


def test_parameters_of_a_description() -> None:
    """All numbers but those of modes and tables over temperature."""
    paths = {one.path for one in design_parameters(CONTENT)}
    assert {'disc.rotor_thickness_mm', 'pads.young_modulus_gpa', 'damping_ratio',
            'friction.decay_s_m'} < paths
    assert not any(path.startswith(('modes', 'friction.temperature')) for path in paths)


def test_worst_points_of_a_drive(kang: BrakeModel) -> None:
    """Released and standing brakes do not count; the worst is that of the largest growth."""
    speed, pressure = np.array([5.0, 5.0, 20.0, 0.0, 5.0]), np.array([8e5, 8e5, 8e5, 8e5, 0.0])
    found = worst_points(kang, speed, pressure, np.array([0.3, 0.6, 0.3, 0.9, 0.9]), 1)
    assert (found[0].rotor_speed, found[0].friction) == (5.0, 0.6)
    assert found[0].share == pytest.approx(1 / 3)


def test_worst_points_of_a_drive_that_goes_backwards_too(kang: BrakeModel) -> None:
    """Speeds both ways have no mean: the brake is its own mirror image, so both grow alike."""
    speed, same = np.array([5.0, -5.0, 5.0]), np.ones(3)
    found = worst_points(kang, speed, 8e5 * same, 0.6 * same, 1)
    alone = worst_points(kang, speed[:1], 8e5 * same[:1], 0.6 * same[:1], 1)
    assert abs(found[0].rotor_speed) == 5.0
    assert found[0].share in (pytest.approx(1 / 3), pytest.approx(2 / 3))
    # two merged roots move by sqrt(eps) of their coupling, ~1e3 1/s
    assert found[0].growth_rate == pytest.approx(alone[0].growth_rate, abs=1e-4)


def test_masses_split_a_doublet(kang: BrakeModel) -> None:
    """Without contact all angles are alike; small masses act as Rayleigh's quotient says."""
    masses = SplitDoublet.of(kang, 3, split=0.01)
    assert masses.split == pytest.approx(0.01, rel=1e-6)
    assert masses.count == 6
    spectra = [np.linalg.eigvalsh(np.diag(kang.angular_frequencies**2)
                                  + model.support_stiffness)  # type: ignore[operator]
               for model in (masses.at(0.0), masses.at(0.31))]
    np.testing.assert_allclose(spectra[0][6:], spectra[1][6:], rtol=1e-6)
    ring = DiscRing.of(kang)
    shape = ring.at(np.zeros(1))[:, list(masses.doublet)]
    small = SplitDoublet.of(kang, 3, mass=1e-5)
    # 2n masses where one of the two moves radially and axially and the other tangentially
    squares = np.sum(small._added(0.0)[np.ix_(small.doublet, small.doublet)] * np.eye(2), axis=0)
    assert small.split == pytest.approx(abs(squares[0] - squares[1]) / 2.0, rel=1e-3)
    assert (shape**2).sum(axis=0).max() * 6e-5 == pytest.approx(squares.max(), rel=1e-3)


def test_side_effects_know_their_doublet(kang: BrakeModel) -> None:
    """Six small masses split that of six diameters as Rayleigh's quotient says; pads have none."""
    masses = SplitDoublet.of(kang, 3, mass=1e-5)
    point = OperatingPoint(rotor_speed=5.0, friction=0.42, contact_pressure=7.8e5,
                           contact_stiffness=kang.nominal_contact_stiffness)
    roots = complex_modes(kang, point).oscillatory

    def led(hertz: float) -> tuple[int, float] | None:
        root = roots[np.abs(roots.imag - math.tau * hertz).argmin()]
        return led_doublet(masses, point, ModeOverAngle(
            Identity((1,)), root.imag / math.tau, root.real, np.zeros(1)))

    assert led(3211.0) is None
    found = led(5678.0)
    assert found is not None
    pair = masses.ring.doublet(kang, 6)
    low, high = np.linalg.eigvalsh(masses._added(0.0)[np.ix_(pair, pair)])
    hertz = kang.angular_frequencies[masses.ring.places[pair[0]]] / math.tau
    assert found[0] == 6
    assert found[1] == pytest.approx(0.5 * (high - low) * hertz, rel=1e-3)
    own = led(1661.0)
    first, second = masses.frequencies_hz
    assert own == (3, second - first)


def test_more_mass_lowers_frequencies() -> None:
    """(1 + m)^(-1/2) on one of two modes."""
    loaded = in_basis(PAIR, np.diag([1.1**-0.5, 1.0]), reference=PAIR)
    np.testing.assert_allclose(
        np.diag(loaded.stiffness(AT)), [1e8 / 1.1, 1.02e4**2], rtol=1e-12)


def test_command_without_a_description(tmp_path: Path, capsys: pytest.CaptureFixture[str]
                                       ) -> None:
    """It says first what it cannot vary; JSON has all numbers; the chart is there."""
    model, chart = tmp_path / 'pair.npz', tmp_path / 'tornado.svg'
    PAIR.save(model)
    options = ('sensitivity', str(model), '--rotor-speed', '7', '--friction', '0.3')
    code, out, err = squeal(capsys, *options, '--no-risk')
    lines = out.splitlines()
    assert code == 0, err
    assert 'no description' in lines[0]
    assert 'mode 1' in lines[1]
    assert any(line.startswith('contact.stiffness') for line in lines)
    code, out, err = squeal(capsys, *options, '--json', '--plot', str(chart))
    found = json.loads(out)
    assert code == 0
    assert {one['parameter'] for one in found['parameters']} >= {
        'damping_ratio', 'contact.stiffness', 'rotor_speed'}
    assert found['parameters'][0]['modes'][0]['growth_rate'] != 0.0
    assert '<svg' in chart.read_text(encoding='utf-8')


@pytest.mark.parametrize(('options', 'said'), [
    (('--only', 'foo.bar'), 'begins no parameter'),
    (('--rotor-speed', '5', '--only', 'disk'), 'disc.'),
    (('--rotor-speed', '5', '--modes', '93'), '--modes'),
    (('--rotor-speed', '5', '--split', '1'), '--split-doublet'),
    (('--rotor-speed', '5', '--split-doublet', '3', '--grams', '900'), 'give less'),
    (('--drive', 'us06', '--rotor-speed', '5'), '--drive')])
def test_bad_options(options: tuple[str, ...], said: str,
                     capsys: pytest.CaptureFixture[str]) -> None:
    """One line, exit code 2."""
    code, out, err = squeal(capsys, 'sensitivity', 'kang2009', *options)
    assert (code, out) == (2, '')
    assert said in err
    assert err.count('\n') == 1
