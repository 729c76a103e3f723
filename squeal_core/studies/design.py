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

"""Parameters of a brake description by their path in its YAML, and the brakes that they make."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
import hashlib
from inspect import signature
from pathlib import Path
from typing import Any

from squeal_core.assembly.build import build_model
from squeal_core.assembly.parts import PartCache
from squeal_core.brake.brake_yaml import parse_brake
from squeal_core.brake.design_parameters import leaves, number_paths, with_number
from squeal_core.brake.dimensions import Brake
from squeal_core.common.errors import (
    BrakeDescriptionError,
    did_you_mean,
    short_repr,
    solver_errors,
)
from squeal_core.common.ranges import Warn, warn_implausible
from squeal_core.common.yaml_reader import read_yaml
from squeal_core.model.brake_model import BrakeModel

_SIDES = ('top', 'bottom')
_MOST_MODELS = 8
_BUILT_WITH = {name: item.default for name, item in signature(build_model).parameters.items()}


@dataclass(frozen=True)
class BrakeDesign:
    """
    A brake description whose numbers can be varied.

    Parameters
    ----------
    content : mapping
        Of the YAML.
    where : str
        The file's name, for errors.
    folder : Path
        Where files that it names are.
    settings : mapping
        Of `build_model`, such as `disc_order`.

    """

    content: Mapping[str, Any]
    where: str = 'brake'
    folder: Path = Path()
    settings: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def read(cls, path: str | Path, **settings: Any) -> 'BrakeDesign':
        """Read a description; see `read_brake`."""
        content = read_yaml(path, BrakeDescriptionError)
        return cls(content, Path(path).name, Path(path).resolve().parent, settings)

    @cached_property
    def numbers(self) -> tuple[str, ...]:
        """Return the paths of all numbers, as `disc.rotor_thickness_mm`."""
        return number_paths(self.content)

    def check(self, path: str) -> None:
        """
        Refuse a path at which the description has no number.

        Raises
        ------
        BrakeDescriptionError
            With the nearest path that there is.

        """
        if _pad_of(self.content, path) in self.numbers:
            return
        section = path.rpartition('.')[0]
        beside = [name for name in self.numbers if name.rpartition('.')[0] == section]
        near = did_you_mean(path, self.numbers) or (
            f' (there are {", ".join(beside)})' if beside else '')
        raise BrakeDescriptionError(
            self.where, f'has no number {short_repr(path)}',
            f'give the path of one, with its unit, or add it to the description{near}')

    def brake(self, values: Mapping[str, float], *, warn: Warn = warn_implausible) -> Brake:
        """
        Return the brake with other numbers.

        Parameters
        ----------
        values : mapping
            By path. Of one description of both pads `pads.top` and `pads.bottom` are parts, too:
            the pads differ then.
        warn : callable
            Told of unusual values.

        Raises
        ------
        BrakeDescriptionError
            For an impossible brake.

        """
        content = self.content
        for path, value in sorted(values.items(), key=lambda item: item[0] not in self.numbers):
            self.check(path)
            if _pad_of(content, path) != path:
                content = {**content, 'pads': dict.fromkeys(_SIDES, content['pads'])}
            whole = path.startswith('modes.') and value == int(value)
            content = with_number(content, path, int(value) if whole else value)
        return parse_brake(content, where=self.where, folder=self.folder, warn=warn)

    def file_hashes(self) -> dict[str, str]:
        """Return SHA-256 of the files of modal results that the description names."""
        names = sorted(str(item) for path, item in leaves(self.content)
                       if path.endswith('.file'))
        return {name: hashlib.sha256((self.folder / name).read_bytes()).hexdigest()
                for name in names if (self.folder / name).is_file()}

    def number(self, path: str) -> float:
        """Return the number at a path."""
        self.check(path)
        return float(dict(leaves(self.content))[_pad_of(self.content, path)])


class DesignModels:
    """
    Models of the brakes of a design, of parts that are computed once.

    Parameters
    ----------
    design : BrakeDesign
    cache : path, optional
        Folder of solved parts; None: they are kept in memory.

    """

    def __init__(self, design: BrakeDesign, cache: str | Path | None = None) -> None:
        self.design, self._parts = design, PartCache(cache)
        self._models: dict[tuple[tuple[str, float], ...], BrakeModel] = {}

    def model(self, values: Mapping[str, float]) -> BrakeModel:
        """
        Return the model of the brake with other numbers; warnings are left out.

        Raises
        ------
        SquealError
            For an impossible brake.

        """
        key = tuple(sorted(values.items()))
        if key not in self._models:
            while len(self._models) >= _MOST_MODELS:
                del self._models[next(iter(self._models))]
            self._models[key] = self._built(values)
        return self._models[key]

    def _built(self, values: Mapping[str, float]) -> BrakeModel:
        brake = self.design.brake(values, warn=lambda _: None)
        with solver_errors(f'{self.design.where}: no model can be built', 'check the dimensions'):
            return build_model(brake, parts=self._parts, **self.design.settings)

    def solve_part(self, values: Mapping[str, float], part: str) -> None:
        """Solve the 'disc' or the 'pads' of a brake and keep them in the cache."""
        brake = self.design.brake(values, warn=lambda _: None)
        settings = {**_BUILT_WITH, **self.design.settings}
        if part == 'disc':
            self._parts.disc(brake, settings['disc_order'])
        else:
            self._parts.pads(brake, settings['pad_elements'])


def _pad_of(content: Mapping[str, Any], path: str) -> str:
    """Return the path of one pad's number in a description of both."""
    sections = path.split('.')
    pads = content.get('pads')
    if sections[0] == 'pads' and sections[1:2] and sections[1] in _SIDES and (
            isinstance(pads, Mapping) and not {*_SIDES} & {*pads}):
        return '.'.join(['pads', *sections[2:]])
    return path
