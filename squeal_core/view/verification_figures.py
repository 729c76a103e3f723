"""K09's figures from a verification: curves, maps and loci, and the shapes of the modes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

try:
    from matplotlib import rc_context
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm
    from matplotlib.figure import Figure
    from PIL import Image
except ImportError as error:
    raise ImportError("plots need matplotlib: pip install 'squeal_ros[view]'") from error
import numpy as np

from squeal_core import verification
from squeal_core.arrays import ComplexArray, FloatArray
from squeal_core.brake import HatDisc
from squeal_core.brake_model import BrakeModel
from squeal_core.friction import FrictionLaw
from squeal_core.mechanism import without_rotation
from squeal_core.modal_basis import ModalBasis, Quadrature
from squeal_core.operating_point import OperatingPoint
from squeal_core.stability import complex_modes, Mode, mode_vectors
from squeal_core.verification import Case, Pair, Parts, Verification
from squeal_core.view.locus_plot import plot_growth_rates, plot_loci
from squeal_core.view.stability_map import plot_stability_map, STYLE

Direction: TypeAlias = Literal['normal', 'tangential']
_LEVELS = np.linspace(-1.0, 1.0, 16)  # an even number of bands: none of them straddles zero
_NORM, _MAP, _DPI = BoundaryNorm(_LEVELS, 256), 'RdBu_r', 100
_WORDS = {'normal': 'out of plane', 'tangential': 'along the rotation'}
_LEAST_GROWTH = 2.0  # 1/s, of the modes that fig. 15 shows


def write_figures(result: Verification, folder: str | Path, *,
                  progress: Callable[[str], None] = lambda _: None) -> tuple[Path, ...]:
    """Draw K09's figures 8 to 16 as PNG; without scikit-fem those that show no shapes.

    Parameters
    ----------
    result : Verification
    folder : path
        Made where it does not exist.
    progress : callable
        Told each file's name.

    Returns
    -------
    tuple of Path
        What was written. What was not, `result.skipped` says.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    drawings = {'09': _friction_curves, '10': _map_slow, '11': _loci_pads, '12': _loci_third,
                '13': _map_fast, '15': _growth_over_speed, '11_softer': _loci_softer}
    if result.parts:
        drawings |= {'08': _components, '11_sums': _loci_sums, '11a': _shapes_pads,
                     '12a': _shapes_third, '14': _shapes_added, '16': _shape_torsion}
    written = []
    for name, draw in sorted(drawings.items()):
        path = folder / f'figure_{name}.png'
        progress(path.name)
        draw(result, path)
        _compact(path)
        written.append(path)
    return tuple(written)


def _compact(path: Path) -> None:
    """Write a PNG again with a palette: a third of the size, and no difference to be seen."""
    with Image.open(path) as picture:
        flat = picture.convert('RGB').quantize(256, dither=Image.Dither.NONE)
    flat.save(path, optimize=True)


# ---------------------------------------------------------------- curves, maps and loci

def _friction_curves(result: Verification, path: Path) -> None:
    model, law = result.model, result.model.friction_law
    assert isinstance(law, FrictionLaw)  # `verify` refuses a model without
    speed = np.linspace(0.0, 25.0, 251)
    with rc_context(STYLE):
        figure = Figure(figsize=(6.0, 3.6), layout='constrained')
        axes = figure.subplots()
        axes.plot(speed, [law.coefficient(model.contact_radius * s) for s in speed],
                  color='#1b5e9b', label=f'µ = {law.kinetic:g} + {law.static - law.kinetic:.2g} '
                  f'exp(-{law.decay:g} s/m · v)')
        axes.axhline(verification.FRICTION, color='#c8432b', linestyle='--',
                     label=f'µ = {verification.FRICTION:g}')
        axes.set(xlabel='rotor speed  rad/s', ylabel='friction coefficient', xlim=(0.0, 25.0),
                 ylim=(0.3, 0.52), yticks=np.arange(0.3, 0.52, 0.05))
        top = axes.secondary_xaxis('top', functions=(
            lambda s: np.asarray(s) * model.contact_radius,
            lambda v: np.asarray(v) / model.contact_radius))
        top.set_xlabel(f'sliding speed v at r = {1e3 * model.contact_radius:.1f} mm  m/s')
        axes.grid(color='0.93')
        axes.legend(frameon=False)
        figure.savefig(path, dpi=_DPI)


def _map_slow(result: Verification, path: Path) -> None:
    plot_stability_map(result.records['figure 10'], path, title='As K09 fig. 10')


def _map_fast(result: Verification, path: Path) -> None:
    plot_stability_map(result.records['figure 13'], path, title='As K09 fig. 13')


def _loci_pads(result: Verification, path: Path) -> None:
    _loci(result, 'friction', verification.PADS, path, 'As K09 fig. 11: rigid modes of the pads')


def _loci_third(result: Verification, path: Path) -> None:
    _loci(result, 'friction', verification.THIRD, path,
          'As K09 fig. 12: third doublet of the disc')


def _loci_softer(result: Verification, path: Path) -> None:
    modes = Case(without_rotation(result.model)).soft_pair(verification.SOFTER[1])
    _loci(result, 'friction, softer', _numbers(modes), path,
          f'Rigid modes of the pads at {verification.SOFTER[1]:.0%} of the contact stiffness')


def _loci_sums(result: Verification, path: Path) -> None:
    assert result.parts
    modes = Case(without_rotation(result.parts.by_sums)).soft_pair(1.0)
    _loci(result, 'friction, sums', _numbers(modes), path,
          'Rigid modes of the pads, contact integrals as sums over 15 x 43 nodes')


def _loci(result: Verification, name: str, numbers: Pair, path: Path, title: str) -> None:
    plot_loci(result.records[name], numbers, path, title=title,
              without=result.records[f'{name}, no rotation'])


def _growth_over_speed(result: Verification, path: Path) -> None:
    record = result.records['figure 15']
    found = {int(text.split('/')[0]) for text in np.unique(record.identities[
        (record.kinds == 'flutter') & (record.eigenvalues.real > _LEAST_GROWTH)]).tolist()}
    plot_growth_rates(record, path, numbers=sorted(found), title='As K09 fig. 15: modes that grow '
                      f'by more than {_LEAST_GROWTH:g} 1/s')


# ---------------------------------------------------------------- shapes

@dataclass(frozen=True, eq=False)
class _Patch:
    """A piece of surface, seen from above [mm], and the shapes (N, rows, columns) on it."""

    x: FloatArray
    y: FloatArray
    normal: FloatArray
    tangential: FloatArray
    radial: FloatArray
    place: slice

    def motion(self, vector: ComplexArray, direction: str) -> ComplexArray:
        """Return a component of the motion of modal coordinates (N,) of the brake."""
        shapes: FloatArray = getattr(self, direction)
        return np.asarray(np.tensordot(vector[self.place], shapes, (0, 0)))


@dataclass(frozen=True)
class _Picture:
    """The surfaces of the brake that are drawn: hat and rotor from above, and pads."""

    disc: tuple[_Patch, _Patch]
    pads: tuple[_Patch, _Patch]

    @classmethod
    def of(cls, parts: Parts) -> '_Picture':
        disc, contact = parts.brake.disc, parts.brake.contact
        assert isinstance(disc, HatDisc)  # else there are no parts
        first, half = len(parts.pads[0].names), 0.5 * disc.rotor_thickness
        whole, sector = (0.0, 2.0 * np.pi), (-0.5 * contact.angle, 0.5 * contact.angle)
        own, last = slice(first, -len(parts.pads[1].names)), slice(-len(parts.pads[1].names), None)
        hat = _patch(parts.disc, (disc.clamp_radius, disc.hat_wall_outer_radius), whole,
                     half + disc.hat_height, own)
        rotor = _patch(parts.disc, (disc.hat_wall_outer_radius, disc.rotor_outer_radius), whole,
                       half, own)
        radii = contact.inner_radius, contact.outer_radius
        return cls((hat, rotor), (
            _patch(parts.pads[0], radii, sector, half, slice(0, first)),
            _patch(parts.pads[1], radii, sector, -half, last)))

    def in_phase(self, vector: ComplexArray, direction: Direction) -> ComplexArray:
        """Return a vector with the phase at which most is seen to move, its largest motion 1."""
        motion = np.concatenate([patch.motion(vector, direction).ravel()
                                 for patch in (*self.disc, *self.pads)])
        turn = np.exp(-0.5j * np.angle(np.sum(motion**2)))
        seen = (motion * turn).real
        return np.asarray(vector * turn / seen[np.abs(seen).argmax()])


def _patch(basis: ModalBasis, radii: tuple[float, float], angles: tuple[float, float],
           height: float, place: slice) -> _Patch:
    around = round(np.ptp(angles) / np.deg2rad(1.5)) + 1
    r, t = np.meshgrid(np.linspace(*radii, 25), np.linspace(*angles, around), indexing='ij')
    inside = np.clip(r, radii[0] * (1.0 + 1e-6), radii[1] * (1.0 - 1e-6)).ravel()
    s = basis.sample(Quadrature(inside, (1.0 - 1e-6) * t.ravel(), np.full(r.size, height),
                                np.ones(r.size)))
    normal, tangential, radial = (part.reshape(-1, *r.shape)
                                  for part in (s.normal, s.tangential, s.radial))
    return _Patch(1e3 * r * np.cos(t), 1e3 * r * np.sin(t), normal, tangential, radial, place)


def _components(result: Verification, path: Path) -> None:
    """Modes of the components that K09 names, as its fig. 8."""
    assert result.parts
    picture, names = _Picture.of(result.parts), result.model.names
    with rc_context({**STYLE, 'axes.titlesize': 9, 'axes.titlelocation': 'center'}):
        figure = Figure(figsize=(9.0, 7.6), layout='constrained')
        panels = figure.subplots(3, 3).ravel()
        for axes, (_, name, words, *_) in zip(panels, verification.PRINTED, strict=True):
            direction: Direction = 'tangential' if name == verification.TORSION else 'normal'
            vector = np.eye(len(names), dtype=complex)[names.index(name)]
            patches = picture.pads[:1] if name.startswith('pad') else picture.disc
            _draw(axes, patches, picture.in_phase(vector, direction), direction)
            hertz = result.model.angular_frequencies[names.index(name)] / 2.0 / np.pi
            axes.set_title(f'{words}: {hertz:.0f} Hz\n{_WORDS[direction]}')
        _finish(figure, panels, path, 'Modes of the components, as K09 fig. 8')


def _shapes_pads(result: Verification, path: Path) -> None:
    _shapes(result, path, 'As K09 fig. 11a', Case(result.model).at(verification.SLOW),
            verification.PADS)


def _shapes_third(result: Verification, path: Path) -> None:
    _shapes(result, path, 'As K09 fig. 12a', Case(result.model).at(verification.SLOW),
            verification.THIRD)


def _shapes_added(result: Verification, path: Path) -> None:
    case = Case(result.model)
    meant = verification.added_pairs(case)[1].values()
    _shapes(result, path, 'As K09 fig. 14', case.at(verification.FAST),
            [number for pair in meant for number in pair])


def _shape_torsion(result: Verification, path: Path) -> None:
    case = Case(result.model)
    point = case.by_law(verification.SLOW)
    mode = case.of_torsion(complex_modes(result.model, point), point)
    _shapes(result, path, 'As K09 fig. 16', point, [mode.index],
            direction='tangential')


def _shapes(result: Verification, path: Path, title: str, point: OperatingPoint,
            numbers: Sequence[int], *, direction: Direction = 'normal') -> None:
    """Draw modes of the brake by their place in order of frequency, two in a row."""
    assert result.parts
    picture = _Picture.of(result.parts)
    modes = [complex_modes(result.parts.model, point).modes[number - 1] for number in numbers]
    rows, columns = -(-len(modes) // 2), min(2, len(modes))
    with rc_context({**STYLE, 'axes.titlesize': 9, 'axes.titlelocation': 'center'}):
        figure = Figure(figsize=(5.2 * columns, 3.4 * rows + 1.2), layout='constrained')
        panels = figure.subplots(rows, 3 * columns, squeeze=False,
                                 width_ratios=(3, 1, 1) * columns).reshape(-1, 3)
        for row, mode in zip(panels, modes, strict=True):
            _mode(row, picture, result.parts.model, point, mode, direction)
        _finish(figure, panels.ravel(), path, f'{title}, Ω = {point.rotor_speed:g} rad/s, '
                f'µ = {point.friction:.3g}\nmotion {_WORDS[direction]}; pads drawn larger')


def _mode(row: Any, picture: _Picture, model: BrakeModel, point: OperatingPoint,
          mode: Mode, direction: Direction) -> None:
    vector = picture.in_phase(mode_vectors(model, point, mode.eigenvalue).right, direction)
    for axes, patches, words in zip(row, (picture.disc, *((pad,) for pad in picture.pads)), (
            f'mode {mode.index}: {mode.frequency_hz:.0f} Hz, {mode.growth_rate:+.1f} 1/s',
            'pad 1 (top)', 'pad 2'), strict=True):
        _draw(axes, patches, vector, direction)
        axes.set_title(words)
    for pad in picture.pads:
        _outline(row[0], pad, color='black', linestyle=(0, (4, 2)))
    if direction == 'tangential':
        rotor = picture.disc[1]
        out, along = (rotor.motion(vector, way).real for way in ('radial', 'tangential'))
        c, s = rotor.x / np.hypot(rotor.x, rotor.y), rotor.y / np.hypot(rotor.x, rotor.y)
        some = (slice(4, None, 8), slice(None, None, 12))
        row[0].quiver(rotor.x[some], rotor.y[some], (c * out - s * along)[some],
                      (s * out + c * along)[some], scale=16.0, width=0.006)


def _draw(axes: Any, patches: Sequence[_Patch], vector: ComplexArray,
          direction: Direction) -> None:
    for patch in patches:
        axes.contourf(patch.x, patch.y, patch.motion(vector, direction).real, levels=_LEVELS,
                      norm=_NORM, cmap=_MAP, extend='both')
        _outline(axes, patch, color='0.3')


def _outline(axes: Any, patch: _Patch, **look: Any) -> None:
    lines = [(patch.x[edge], patch.y[edge]) for edge in (0, -1)]
    if not np.allclose(patch.y[:, 0], patch.y[:, -1]):  # no ring
        lines += [(patch.x[:, edge], patch.y[:, edge]) for edge in (0, -1)]
    for x, y in lines:
        axes.plot(x, y, linewidth=0.8, **look)


def _finish(figure: Any, panels: Any, path: Path, title: str) -> None:
    for axes in panels:
        axes.set_aspect('equal')
        axes.set_axis_off()
    figure.colorbar(ScalarMappable(_NORM, _MAP), ax=list(panels), location='bottom', aspect=50,
                    shrink=0.6, label='displacement, of the largest shown', pad=0.04,
                    ticks=(-1, 0, 1))
    figure.suptitle(title, fontsize=11, x=0.01, ha='left')
    figure.savefig(path, dpi=_DPI)


def _numbers(modes: tuple[Mode, Mode]) -> Pair:
    first, second = sorted(mode.index for mode in modes)
    return first, second
