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

"""K09's figures from a verification: curves, maps and loci, and the shapes of the modes."""

from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

try:
    from matplotlib import rc_context
    from matplotlib.figure import Figure
    from PIL import Image
except ImportError as error:
    raise ImportError("plots need matplotlib: pip install -e '.[view]' in the checkout") from error
import numpy as np
from squeal_core.brake.friction import FrictionLaw
from squeal_core.common.output import check_target, make_folder, OutputFiles
from squeal_core.stability.eigensolution import complex_modes, Mode
from squeal_core.stability.mechanism import without_rotation
from squeal_core.verification import Verification
from squeal_core.verification.case import added_pairs, Case
from squeal_core.verification.paper import FAST, FRICTION, PADS, Pair, SLOW, SOFTER, THIRD
from squeal_core.view.locus_plot import plot_growth_rates, plot_loci
from squeal_core.view.saving import FigureTarget, save_figure
from squeal_core.view.stability_map import plot_stability_map, STYLE
from squeal_core.view.verification_shapes import draw_components, draw_modes

_DPI = 100
_HIGHEST = 8000.0  # Hz, where K09's maps end
_LEAST_GROWTH = 2.0  # 1/s, of the modes that fig. 15 shows


def write_figures(result: Verification, folder: str | Path, *,
                  overwrite: bool = True, progress: Callable[[str], None] = lambda _: None
                  ) -> tuple[Path, ...]:
    """
    Draw K09's figures 8 to 16 as PNG; without scikit-fem those that show no shapes.

    Parameters
    ----------
    result : Verification
        Of `verify`.
    folder : path
        Made where it does not exist.
    overwrite : bool
        Whether existing figures may be replaced.
    progress : callable
        Told each file's name.

    Returns
    -------
    tuple of Path
        What was written. What was not, `result.skipped` says.

    """
    written = []
    with OutputFiles(overwrite=overwrite) as files:
        for name, draw in sorted(_drawings(with_shapes=result.parts is not None).items()):
            path = make_folder(folder) / f'figure_{name}.png'
            progress(path.name)
            with files.add(path).partial.open('wb') as file:
                draw(result, drawn := BytesIO())
                _compact(drawn, file)
            written.append(path)
    return tuple(written)


def check_figures(folder: str | Path, *, overwrite: bool) -> None:
    """Refuse, before any work, figures that could not be written."""
    for name in _drawings(with_shapes=True):
        check_target(make_folder(folder) / f'figure_{name}.png', overwrite=overwrite)


def _drawings(*, with_shapes: bool) -> dict[str, Callable[[Verification, FigureTarget], None]]:
    """Return the function that draws each figure, by its number."""
    drawings: dict[str, Callable[[Verification, FigureTarget], None]] = {
        '09': _friction_curves, '10': _map_slow, '11': _loci_pads, '12': _loci_third,
        '13': _map_fast, '15': _growth_over_speed, '11_softer': _loci_softer}
    if with_shapes:
        drawings |= {'08': _components, '11_sums': _loci_sums, '11a': _shapes_pads,
                     '12a': _shapes_third, '14': _shapes_added, '16': _shape_torsion}
    return drawings


def _compact(drawn: BytesIO, file: BinaryIO) -> None:
    """Write a PNG again with a palette: a third of the size, and no difference to be seen."""
    with Image.open(drawn) as picture:
        flat = picture.convert('RGB').quantize(256, dither=Image.Dither.NONE)
    flat.save(file, format='PNG', optimize=True)


def _friction_curves(result: Verification, path: FigureTarget) -> None:
    model, law = result.model, result.model.friction_law
    assert isinstance(law, FrictionLaw)  # `verify` refuses a model without
    speed = np.linspace(0.0, 25.0, 251)
    with rc_context(STYLE):
        figure = Figure(figsize=(6.0, 3.6), layout='constrained')
        axes = figure.subplots()
        axes.plot(speed, [law.coefficient(model.contact_radius * s) for s in speed],
                  color='#1b5e9b', label=f'µ = {law.kinetic:g} + {law.static - law.kinetic:.2g} '
                  f'exp(-{law.decay:g} s/m · v)')
        axes.axhline(FRICTION, color='#c8432b', linestyle='--',
                     label=f'µ = {FRICTION:g}')
        axes.set(xlabel='rotor speed  rad/s', ylabel='friction coefficient', xlim=(0.0, 25.0),
                 ylim=(0.3, 0.52), yticks=np.arange(0.3, 0.52, 0.05))
        top = axes.secondary_xaxis('top', functions=(
            lambda s: np.asarray(s) * model.contact_radius,
            lambda v: np.asarray(v) / model.contact_radius))
        top.set_xlabel(f'sliding speed v at r = {1e3 * model.contact_radius:.1f} mm  m/s')
        axes.grid(color='0.93')
        axes.legend(frameon=False)
        save_figure(figure, path, dpi=_DPI)


def _map_slow(result: Verification, path: FigureTarget) -> None:
    plot_stability_map(result.records['figure 10'], path, title='As K09 fig. 10',
                       highest_hz=_HIGHEST, paper=True)


def _map_fast(result: Verification, path: FigureTarget) -> None:
    plot_stability_map(result.records['figure 13'], path, title='As K09 fig. 13',
                       highest_hz=_HIGHEST, paper=True)


def _loci_pads(result: Verification, path: FigureTarget) -> None:
    _loci(result, 'friction', PADS, path, 'As K09 fig. 11: rigid modes of the pads')


def _loci_third(result: Verification, path: FigureTarget) -> None:
    _loci(result, 'friction', THIRD, path,
          'As K09 fig. 12: third doublet of the disc')


def _loci_softer(result: Verification, path: FigureTarget) -> None:
    modes = Case(without_rotation(result.model)).soft_pair(SOFTER[1])
    _loci(result, 'friction, softer', _numbers(modes), path,
          f'Rigid modes of the pads at {SOFTER[1]:.0%} of the contact stiffness')


def _loci_sums(result: Verification, path: FigureTarget) -> None:
    assert result.parts
    modes = Case(without_rotation(result.parts.by_sums)).soft_pair(1.0)
    _loci(result, 'friction, sums', _numbers(modes), path,
          'Rigid modes of the pads, contact integrals as sums over 15 x 43 nodes')


def _loci(result: Verification, name: str, numbers: Pair, path: FigureTarget, title: str) -> None:
    plot_loci(result.records[name], numbers, path, title=title,
              without=result.records[f'{name}, no rotation'], paper=True)


def _growth_over_speed(result: Verification, path: FigureTarget) -> None:
    record = result.records['figure 15']
    found = {int(text.split('/')[0]) for text in np.unique(record.identities[
        (record.kinds == 'flutter') & (record.eigenvalues.real > _LEAST_GROWTH)]).tolist()}
    plot_growth_rates(record, path, numbers=sorted(found), paper=True,
                      title='As K09 fig. 15: modes that grow '
                      f'by more than {_LEAST_GROWTH:g} 1/s')


def _numbers(modes: tuple[Mode, Mode]) -> Pair:
    first, second = sorted(mode.index for mode in modes)
    return first, second


# ---------------------------------------------------------------- shapes

def _components(result: Verification, path: FigureTarget) -> None:
    assert result.parts
    draw_components(result.parts, path, 'Modes of the components, as K09 fig. 8')


def _shapes_pads(result: Verification, path: FigureTarget) -> None:
    assert result.parts
    draw_modes(result.parts, path, 'As K09 fig. 11a', Case(result.model).at(SLOW), PADS)


def _shapes_third(result: Verification, path: FigureTarget) -> None:
    assert result.parts
    draw_modes(result.parts, path, 'As K09 fig. 12a', Case(result.model).at(SLOW), THIRD)


def _shapes_added(result: Verification, path: FigureTarget) -> None:
    assert result.parts
    case = Case(result.model)
    meant = added_pairs(case)[1].values()
    draw_modes(result.parts, path, 'As K09 fig. 14', case.at(FAST),
               [number for pair in meant for number in pair])


def _shape_torsion(result: Verification, path: FigureTarget) -> None:
    assert result.parts
    case = Case(result.model)
    point = case.by_law(SLOW)
    mode = case.of_torsion(complex_modes(result.model, point), point)
    draw_modes(result.parts, path, 'As K09 fig. 16', point, [mode.index], direction='tangential')
