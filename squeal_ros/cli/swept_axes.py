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

"""Swept parameters and their brake, by the options of map, locus and critical."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
import math

import numpy as np
from squeal_core.assembly.build import build_settings
from squeal_core.common import resources
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import did_you_mean, short_repr, SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.parameter_paths import Law, OPERATING
from squeal_core.studies.design import BrakeDesign, DesignModels
from squeal_ros.cli.arguments import DEFAULT_SPEED, is_description
from squeal_ros.cli.axis_conflicts import LOADS, refuse_conflicts, refuse_without_rotation
from squeal_ros.cli.console import warn
from squeal_ros.cli.point_checks import check_values

MOST_VALUES = 100_000  # of one axis


@dataclass(frozen=True)
class StudySource:
    """A model file, or a brake description, as a command names it; parts are kept in `cache`."""

    name: str
    cache: str | None = None

    @cached_property
    def described(self) -> bool:
        """Return whether the source is a description and no model."""
        return is_description(self.name)

    @cached_property
    def model(self) -> BrakeModel:
        """Return the model; that of a description is built."""
        if not self.described:
            return BrakeModel.load(self.name)
        design = self.require_design('')
        design.brake({}, warn=warn)
        return DesignModels(design, self.cache).model({})

    @cached_property
    def design(self) -> BrakeDesign | None:
        """Return the brake description: of the file, or the one that the model was built of."""
        if self.described:
            return BrakeDesign.read(self.name)
        about = self.model.provenance
        content = about.get('description')
        if not isinstance(content, dict) or not isinstance(about.get('settings'), dict):
            return None
        return BrakeDesign(content, str(content.get('name', self.name)),
                           resources.find('models', self.name, '.npz').resolve().parent,
                           build_settings(self.model))

    def require_design(self, parameter: str) -> BrakeDesign:
        """Return the description, refusing a parameter that there is none of."""
        if self.design is None:
            raise SquealError(f'{parameter}: {self.name} holds no brake description; give its '
                              'BRAKE.yaml in place of the model')
        return self.design

    @property
    def has_friction_law(self) -> bool:
        """Return whether friction may follow a law; descriptions have one."""
        return self.described or self.model.friction_law is not None

    @property
    def has_stiffness_table(self) -> bool:
        """Return whether contact stiffness follows a table over contact pressure."""
        if not self.described:
            return self.model.stiffness_table is not None
        return 'stiffness_table' in (self.require_design('').content.get('contact') or {})

    @property
    def load_counts(self) -> bool:
        """Return whether more depends on the load than the terms of rotation do."""
        return self.has_stiffness_table or (
            not self.described and self.model.follower is not None)

    def parameter(self, option: str, name: str, axis: str = '') -> str:
        """Return the name of a parameter that there is, of the operation or a path."""
        if name in OPERATING:
            return name
        known = [*OPERATING, *(self.design.numbers if self.design else ())]
        if '.' not in name and name not in known:
            what = (f'{short_repr(axis)} is no axis; write NAME=FROM:TO:COUNT with a name' if axis
                    else f'is {short_repr(name)}; give one')
            raise SquealError(f'{option}: {what} out of {", ".join(OPERATING)}, or the path of a '
                              f'number of the brake description{did_you_mean(name, known)}')
        self.require_design(f'{option} {name}').check(name)
        return name


def read_axes(texts: Sequence[str], source: StudySource) -> dict[str, FloatArray]:
    """Read `friction=0:0.8:81` and so on: from, to, number of points."""
    axes: dict[str, FloatArray] = {}
    for text in texts:
        name, values = _axis(text, source)
        if name in axes:
            raise SquealError(f'--over: {name}, {name}; give each one once')
        axes[name] = values
        if name in OPERATING:
            check_values(f'--over {name}', name, {float(values[0]), float(values[-1])})
    loads = [name for name in axes if name in LOADS]
    if len(loads) > 1:
        raise SquealError(f'--over: {" and ".join(loads)} are one load; give one of them')
    return axes


def _axis(text: str, source: StudySource) -> tuple[str, FloatArray]:
    name, _, span = text.partition('=')
    try:
        start, stop, count = span.split(':')
        low, high, number = float(start), float(stop), int(count)
        if not 1 <= number <= MOST_VALUES or not math.isfinite(low) or not math.isfinite(high):
            raise ValueError
    except ValueError:
        source.parameter('--over', name, text)
        raise SquealError(
            f'--over: {short_repr(text)} is no axis; write NAME=FROM:TO:COUNT, at most '
            f'{MOST_VALUES} points') from None
    source.parameter('--over', name, text)
    if low > high:
        raise SquealError(f'--over: {short_repr(text)} runs down; give the lower end first '
                          f'({name}={stop}:{start}:{count})')
    if low == high and number > 1:
        raise SquealError(f'--over: {short_repr(text)} has no width; give another end, or one '
                          f'point ({name}={start}:{stop}:1)')
    return name, np.linspace(low, high, number)


def settle_point(options: argparse.Namespace, axes: dict[str, FloatArray],
                 source: StudySource, searched: str = '') -> Law:
    """Set speed and friction that are swept or not given, and return what follows the law."""
    refuse_conflicts(options, axes, searched, stiffness_table=source.has_stiffness_table)
    if options.rotor_speed is None:
        options.rotor_speed = float(axes['rotor_speed'][0] if 'rotor_speed' in axes
                                    else DEFAULT_SPEED)
    law = follows_law(source.has_friction_law, options, *axes)
    for name in axes:
        refuse_without_rotation(options, name, axes, law, load_counts=source.load_counts)
    if 'friction' in axes and options.friction is None:
        # swept friction counts as given: constant, or a law's scaled to it, as with --friction
        options.friction = float(np.abs(axes['friction']).max()) or 1.0
    return law


def follows_law(has_law: bool, options: argparse.Namespace, *swept: str) -> Law:
    """Return the quantities that follow the friction law over speed: default, those not given."""
    if 'rotor_speed' not in swept or 'friction_slope' in swept:
        return False
    if 'friction' in swept or options.friction is not None:
        return 'slope' if options.friction_law else False
    if options.friction_slope is not None:
        raise SquealError('--friction-slope: friction would follow its law and the slope would '
                          'not; give --friction too')
    return has_law
