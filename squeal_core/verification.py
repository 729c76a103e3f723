"""What K09 says against what this project gives: one row a claim, every number computed.

The only numbers written here are the paper's and the tolerances. Where the two differ and it is
known why, the row says so; any other difference makes `Verification.passed` False.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
import textwrap
from typing import Any, get_args, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from squeal_core import operators
from squeal_core.arrays import FloatArray
from squeal_core.brake import Brake, HatDisc
from squeal_core.brake_file import parse_brake
from squeal_core.brake_model import BrakeModel
from squeal_core.build import contact_arrays, contact_faces
from squeal_core.critical import critical_value
from squeal_core.errors import SquealError
from squeal_core.mechanism import Mechanism, mechanisms, without_rotation
from squeal_core.merging import merging
from squeal_core.modal_basis import ModalBasis
from squeal_core.operating_point import OperatingPoint
from squeal_core.planar_mesh import AS_PRINTED, contact_grid
from squeal_core.stability import complex_modes, ComplexModes, Mode, mode_vectors
from squeal_core.sweep import sweep
from squeal_core.sweep_record import Sweep
from squeal_core.tracking import identify, moved

Verdict: TypeAlias = Literal['reproduced', 'within fit', 'NOT reproduced']
Pair: TypeAlias = tuple[int, int]
FRICTION, PRELOAD, SLOW, FAST = 0.42, 2000.0, 5.0, 20.0  # K09: -, N, rad/s, rad/s
THIRD, PADS = (13, 14), (25, 26)  # K09's numbers of its two squeal pairs
ADDED = ((19, 20), (39, 40))  # those of fig. 14
EXACT, FIT = 1e-3, 5e-3  # of frequencies: as printed; as a fitted hat and another mesh leave them
SOFTER = (0.70, 0.71, 0.72)  # of the nominal contact stiffness
TORSION = 'disc (0,0)s'
_HAT, _MESH = ('the dimensions are fitted to these frequencies, for K09 does not print them',
               "the pad's dimensions are printed, so this is the mesh: K09's is not known, this "
               'one is converged (docs/convergence.md)')
PRINTED = (  # Hz in K09, the mode's name here, in words, where printed, why it may differ
    (3431.0, 'pad 1 flexible 1', 'first bending of the pad', 'sec. 3', _MESH),
    (5720.0, 'pad 1 flexible 2', 'first torsion of the pad', 'sec. 3', _MESH),
    (1365.0, TORSION, 'in-plane torsion of the disc', 'sec. 3', _HAT),
    (727.0, 'disc (0,0)c', 'umbrella mode of the disc', 'fig. 8', _HAT),
    (1896.0, 'disc (0,1)c', 'second umbrella mode', 'fig. 8', _HAT),
    (1959.0, 'disc (1,1)c', 'disc, 1 nodal diameter', 'fig. 8', _HAT),
    (4820.0, 'disc (3,1)c', 'disc, 3 nodal diameters', 'fig. 8', _HAT),
    (4920.0, 'disc (2,2)c', 'disc, 2 nodal diameters', 'fig. 8', _HAT),
    (7528.0, 'disc (4,1)c', 'disc, 4 nodal diameters', 'fig. 8', _HAT))


@dataclass(frozen=True, kw_only=True)
class Row:
    """One claim of the paper, in our words, and what becomes of it here.

    `known` says that a difference is understood, and `reason` why; see `Verification.passed`.
    """

    claim: str
    source: str
    paper: str
    project: str
    tolerance: str
    verdict: Verdict
    reason: str = ''
    known: bool = False


@dataclass(frozen=True, eq=False)
class Parts:
    """Modes of disc and pads, and the model whose coordinates are theirs, signs included."""

    brake: Brake
    disc: ModalBasis
    pads: tuple[ModalBasis, ModalBasis]
    faces: tuple[operators.ContactFace, ...]
    model: BrakeModel

    @cached_property
    def by_sums(self) -> BrakeModel:
        """The model with contact integrals as sums over 15 x 43 nodes, as K09 eq. (40) reads."""
        half = 0.5 * _hat(self.brake).rotor_thickness
        top, bottom = (contact_grid(self.brake.contact, z, AS_PRINTED) for z in (half, -half))
        first, second = self.pads
        return replace(self.model, **contact_arrays((  # type: ignore[arg-type]
            operators.top_face(first.sample(top), self.disc.sample(top), len(second.names)),
            operators.bottom_face(second.sample(bottom), self.disc.sample(bottom),
                                  len(first.names)))))


@dataclass(frozen=True, eq=False, kw_only=True)
class Verification:
    """Rows of the table, the sweeps behind them and K09's figures, and what was left out why."""

    model: BrakeModel
    rows: tuple[Row, ...]
    records: Mapping[str, Sweep]
    parts: Parts | None
    skipped: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether all that is not reproduced is known not to be, with its reason."""
        return all(row.known for row in self.rows if row.verdict == 'NOT reproduced')

    def count(self, verdict: Verdict) -> int:
        return sum(row.verdict == verdict for row in self.rows)

    def to_json(self) -> dict[str, Any]:
        """Return the table for a program to read."""
        return {'passed': self.passed, 'rows': [asdict(row) for row in self.rows],
                'skipped': list(self.skipped)}


def verify(model: BrakeModel, *, progress: Callable[[str], None] = lambda _: None,
           workers: int = 0) -> Verification:
    """Rerun K09 and return claim by claim what the paper says and what the model gives.

    Parameters
    ----------
    model : BrakeModel
        Of K09's brake: the shipped `kang2009`, or another build of its description.
    progress : callable
        Told in a few words what is being done.
    workers : int
        Processes for the stability maps; 0: this one.

    Raises
    ------
    SquealError
        For a model of another brake.
    """
    missing = {name for _, name, *_ in PRINTED} - set(model.names)
    if missing or model.friction_law is None:
        what = ', '.join(sorted(missing)) or 'friction law'
        raise SquealError(f"verify: the model has no {what}; give one of K09's brake, as kang2009")
    progress('modes of disc and pads')
    parts, skipped = _parts(model)
    progress('sweeps')
    case, records = Case(model), _records(model, parts, workers)
    rows: list[Row] = []
    for part in (_components(case), _maps(case), _third_doublet(case), _pad_pair(case, parts),
                 _speed(case, records['figure 15']), _torsion(case, parts)):
        for row in part:
            progress(row.claim)
            rows.append(row)
    return Verification(model=model, rows=tuple(rows), records=records, parts=parts,
                        skipped=skipped)


def _parts(model: BrakeModel) -> tuple[Parts | None, tuple[str, ...]]:
    try:
        return rebuild(model), ()
    except (ImportError, SquealError) as error:
        return None, (f'sums over nodes, follower force, mode shapes: {error}',)


def rebuild(model: BrakeModel) -> Parts:
    """Return the parts that a model of a hat disc was built from, solved anew (needs skfem)."""
    from squeal_core.fe.axisymmetric import disc_modes
    from squeal_core.fe.solid import pad_modes

    brake = parse_brake(model.provenance.get('description', {}))
    settings = model.provenance['settings']
    elements, half = tuple(settings['pad_elements']), 0.5 * _hat(brake).rotor_thickness
    disc = disc_modes(_hat(brake), brake.disc_modes, order=settings['disc_order'])
    pad = pad_modes(brake.pad, brake.contact, brake.pad_modes, elements=elements)
    pads = replace(pad, offset=half), replace(pad, offset=-half - brake.pad.thickness)
    found = np.concatenate([part.angular_frequencies for part in (pads[0], disc, pads[1])])
    if found.shape != (model.size,) or not np.allclose(found, model.angular_frequencies, 1e-6):
        raise SquealError("modes solved anew are not the model's; build the model again")
    faces = contact_faces(brake, disc, pads, elements[:2], settings['contact_points'])
    gyroscopic = operators.gyroscopic(disc.volume_layers(), _hat(brake).material.density)
    return Parts(brake, disc, pads, faces, replace(
        model, gyroscopic=np.pad(gyroscopic, len(pad.names)),
        **contact_arrays(faces)))  # type: ignore[arg-type]


def _hat(brake: Brake) -> HatDisc:
    if not isinstance(brake.disc, HatDisc):
        raise SquealError(f'{brake.name}: its disc comes from a file; give a disc by dimensions')
    return brake.disc


def _records(model: BrakeModel, parts: Parts | None, workers: int) -> dict[str, Sweep]:
    """The sweeps of K09's figures, and of two changed brakes in which its fig. 11 comes out."""
    case, stiffness = Case(model), model.nominal_contact_stiffness * np.linspace(0.02, 1.2, 60)
    speeds = np.concatenate([np.linspace(0.25, 5.0, 20), np.linspace(6.0, 25.0, 20)])
    found = {f'figure {figure}': sweep(model, case.at(speed), {'contact_stiffness': stiffness},
                                       workers=workers)
             for figure, speed in ((10, SLOW), (13, FAST))}
    found['figure 15'] = sweep(model, case.by_law(SLOW), {'rotor_speed': speeds},
                               friction_law=True, tracked=True)
    brakes = {'friction': (model, 1.0), 'friction, softer': (model, SOFTER[1])}
    if parts:
        brakes['friction, sums'] = parts.by_sums, 1.0
    for name, (brake, relative) in brakes.items():
        point, axes = case.at(SLOW, stiffness=relative), {'friction': np.linspace(0.0, 0.6, 61)}
        found[name] = sweep(brake, point, axes, tracked=True)
        found[f'{name}, no rotation'] = sweep(brake, point, axes, rotation=False, tracked=True)
    if not all(record.complete for record in found.values()):
        raise KeyboardInterrupt  # it ends a sweep early, which keeps what it has
    return found


@dataclass(frozen=True)
class Case:
    """A model at K09's operating points."""

    model: BrakeModel

    def at(self, speed: float, *, friction: float = FRICTION,
           stiffness: float = 1.0) -> OperatingPoint:
        """Return a point with constant friction; speed in rad/s, stiffness over nominal."""
        return OperatingPoint(
            rotor_speed=speed, friction=friction,
            contact_pressure=PRELOAD / self.model.contact_area,
            contact_stiffness=stiffness * self.model.nominal_contact_stiffness)

    def by_law(self, speed: float) -> OperatingPoint:
        """Return a point with friction and slope by K09's law (fig. 9)."""
        return moved(self.model, self.at(speed), 'rotor_speed', speed, friction_law=True)

    @property
    def rigid(self) -> NDArray[np.bool_]:
        """Which component modes (N,) are motions of a pad as a rigid body."""
        return np.asarray(self.model.angular_frequencies == 0.0)

    def energy(self, point: OperatingPoint, mode: Mode) -> FloatArray:
        """Return the parts (N,) of the kinetic energy that component modes have."""
        right = np.abs(mode_vectors(self.model, point, mode.eigenvalue).right)**2
        return np.asarray(right / right.sum())

    def of_torsion(self, modes: ComplexModes, point: OperatingPoint) -> Mode:
        """Return the mode with the most in-plane torsion of the disc."""
        place = self.model.names.index(TORSION)
        near = self.model.angular_frequencies[place]
        return max((mode for mode in modes.modes if abs(mode.eigenvalue.imag / near - 1.0) < 0.05),
                   key=lambda mode: self.energy(point, mode)[place])

    def pair(self, numbers: Pair, point: OperatingPoint) -> tuple[Mode, Mode]:
        """Return the modes that carry two numbers, worst first."""
        found = identify(self.model, point).of(numbers)
        return found[0], found[-1]

    def critical_friction(self, numbers: Sequence[int], *, stiffness: float = 1.0) -> float:
        """Return mu at which the modes of these numbers start to grow, at 5 rad/s."""
        return critical_value(self.model, self.at(SLOW, friction=0.3, stiffness=stiffness),
                              'friction', (0.0, 0.8), numbers=numbers,
                              samples=16, tolerance=1e-4).nearest.value

    def critical_speed(self, numbers: Sequence[int], start: float) -> float:
        """Return the speed at which these modes start or cease to grow, friction by its law."""
        return critical_value(self.model, self.by_law(start), 'rotor_speed', (0.25, 25.0),
                              numbers=numbers, ray=self.by_law, samples=25,
                              tolerance=1e-4).nearest.value

    def soft_pair(self, stiffness: float) -> tuple[Mode, Mode]:
        """Return the fastest growing mode of pads that move as rigid bodies, and its neighbour."""
        point = self.at(SLOW, stiffness=stiffness)
        modes = complex_modes(self.model, point)
        worst = next((mode for mode in modes.unstable if mode.kind == 'flutter'
                      and self.energy(point, mode)[self.rigid].sum() > 0.25), modes.modes[-1])
        return worst, min((mode for mode in modes.modes if mode is not worst),
                          key=lambda mode: _gap(worst, mode))


def _said(claim: str, source: str, paper: str, project: str, holds: bool, *, known: bool = False,
          why: str = '', fit: bool = False, tolerance: str = 'as said') -> Row:
    """Return the row of a statement that holds, nearly holds (`fit`) or does not."""
    verdict: Verdict = 'reproduced' if holds else 'within fit' if fit else 'NOT reproduced'
    return Row(claim=claim, source=source, paper=paper, project=project, tolerance=tolerance,
               verdict=verdict, reason='' if holds else why, known=known and not holds)


def _components(case: Case) -> Iterator[Row]:
    for printed, name, words, source, why in PRINTED:
        own = case.model.angular_frequencies[case.model.names.index(name)] / 2.0 / np.pi
        off = abs(own / printed - 1.0)
        yield _said(words, source, f'{printed:g} Hz', f'{own:.1f} Hz, {own / printed - 1:+.2%}',
                    bool(off <= EXACT), fit=bool(off <= FIT), why=why,
                    tolerance=f'{100 * EXACT:g}/{100 * FIT:g} %')


def pairs(modes: ComplexModes) -> dict[Pair, Mode]:
    """Return the flutter modes by the numbers of each and of its neighbour in frequency."""
    found = {}
    for mode in modes.unstable:
        if mode.kind == 'flutter':
            near = min((other for other in modes.modes if other is not mode),
                       key=lambda other: abs(other.frequency_hz - mode.frequency_hz))
            found[min(mode.index, near.index), max(mode.index, near.index)] = mode
    return dict(sorted(found.items()))


def added_pairs(case: Case) -> tuple[dict[Pair, Mode], dict[Pair, Pair], dict[Pair, Mode]]:
    """Return the pairs at 5 rad/s, what K09's two further ones are here, and all added at 20."""
    before, after = (pairs(complex_modes(case.model, case.at(speed))) for speed in (SLOW, FAST))
    added = {pair: mode for pair, mode in after.items() if pair not in before}
    meant = {pair: min(added, key=lambda own: abs(own[0] - pair[0]), default=(0, 0))
             for pair in ADDED}
    return before, meant, added


def _maps(case: Case) -> Iterator[Row]:
    """Figs 10 and 13: which pairs squeal at full stiffness, and who takes part."""
    before, meant, added = added_pairs(case)
    yield _said('pairs that squeal at 5 rad/s', 'fig. 10', _names([THIRD, PADS]), _names(before),
                set(before) == {THIRD, PADS})
    third = np.array([name[:-1] == 'disc (3,0)' for name in case.model.names])
    for pair, words, part in ((THIRD, 'third disc doublet', third), (PADS, 'rigid pads',
                                                                     case.rigid)):
        share = case.energy(case.at(SLOW), before[pair])[part].sum() if pair in before else 0.0
        yield _said(f'what moves in {_names([pair])}', 'sec. 3.1', words,
                    f'{share:.0%} of the energy', bool(share > 0.5), tolerance='over 50 %')
    found = {pair: mechanisms(case.model, case.at(FAST), [added[own]])[0]
             for pair, own in meant.items() if own in added}
    for pair, own in meant.items():
        yield _added(pair, own, found.get(pair))
    for mechanism in found.values():
        yield _gyroscopic(case, mechanism)
    others = {pair: mechanisms(case.model, case.at(FAST), [mode])[0]
              for pair, mode in added.items() if pair not in meant.values()}
    leads = {other.participation[0].name for other in others.values()}
    growth = ', '.join(f'{other.participation[0].name} by {other.mode.growth_rate:.1f} 1/s'
                       for other in others.values())
    yield _said('further pairs at 20 rad/s', 'sec. 3.1', 'none named', ', '.join(
        f'{_names([pair])} ({other.mode.frequency_hz:.0f} Hz)' for pair, other in others.items()
        ) or 'none', not others, known=leads <= {'disc (2,0)', 'disc (7,0)'},
        why=f'the second and the seventh disc doublet grow as well ({growth}); the text does not '
        'say that it names all, and its map (fig. 13) was not compared point by point')


def _added(pair: Pair, own: Pair, found: Mechanism | None) -> Row:
    claim, tolerance = f'{_names([pair])} squeal at 20 rad/s only', 'one place'
    if found is None:
        return _said(claim, 'fig. 14', _names([pair]), 'none', False, tolerance=tolerance)
    parts = ', '.join(f'{part.name} {part.fraction:.0%}' for part in found.participation[:2])
    return _said(claim, 'fig. 14', _names([pair]), f'{_names([own])}, '
                 f'{found.mode.frequency_hz:.0f} Hz', own == pair, tolerance=tolerance,
                 fit=abs(own[0] - pair[0]) <= 1, why='a place in order of frequency depends on '
                 f'neighbours, which a fitted hat moves; in this mode take part {parts}, ...')


def _gyroscopic(case: Case, found: Mechanism) -> Row:
    mode, without = found.mode, found.without
    free = complex_modes(replace(case.model, radial_dissipation=None), case.at(SLOW))
    slow = max((other for other in free.modes if abs(
        other.frequency_hz / mode.frequency_hz - 1.0) < 0.01), key=lambda m: m.growth_rate,
        default=free.modes[0])
    return _said(
        f'{mode.frequency_hz:.0f} Hz: added by gyroscopic term', 'sec. 3.1', 'grows by it',
        f'{mode.growth_rate:+.1f}, without it {without["gyroscopic"]:+.1f} 1/s',
        without['gyroscopic'] <= 0.0, known=min(without['rotation'], slow.growth_rate) > 0.0,
        why=f'it couples by friction without any rotation too ({without["rotation"]:+.1f} 1/s); '
        'what holds it at 5 rad/s is the radial dissipation, in proportion to 1/speed: without '
        f'that it grows there as well ({slow.growth_rate:+.1f} 1/s). The gyroscopic term adds to '
        'it, but is not needed')


def _third_doublet(case: Case) -> Iterator[Row]:
    """Fig. 12 and what section 3.1 says of rotation."""
    still, slow = Case(without_rotation(case.model)), case.at(SLOW)
    first, second = still.pair(THIRD, slow)
    at = merging(still.model, slow, modes=(first, second)).value.real
    yield _said('13/14 merge without rotation', 'fig. 12', 'merge', f'at friction {at:.3f}; '
                f'{_gap(first, second):.2f} Hz apart at 0.42', _merged(first, second))
    turning = Case(replace(case.model, radial_dissipation=None, negative_slope=None))
    one, other = turning.pair(THIRD, slow)
    split = [first.growth_rate - second.growth_rate, one.growth_rate - other.growth_rate]
    yield _said('gyroscopic term splits Re further', 'sec. 3.1', 'strengthens',
                f'{split[0]:.1f} to {split[1]:.1f} 1/s', split[1] > split[0])
    damped = Case(replace(case.model, gyroscopic=None, negative_slope=None))
    low, high, both = (c.critical_friction(THIRD) for c in (still, damped, case))
    yield _said('radial term raises critical friction of 13/14', 'sec. 3.1', 'raises',
                f'{low:.3f} to {high:.3f}; all rotation {both:.3f}', high > low)


def _pad_pair(case: Case, parts: Parts | None) -> Iterator[Row]:
    """Fig. 11: two rigid modes of the pads."""
    still, slow = Case(without_rotation(case.model)), case.at(SLOW)
    damped = Case(replace(case.model, gyroscopic=None, negative_slope=None))
    first, second = still.pair(PADS, slow)
    softer = [still.soft_pair(stiffness) for stiffness in SOFTER]
    at = [merging(still.model, case.at(SLOW, stiffness=k), modes=pair).value.real
          for k, pair in zip(SOFTER, softer, strict=True)]
    near = ', '.join(f'{value:.2f}' for value in at)
    why = (f'with exact contact integrals they stay {_gap(first, second):.0f} Hz apart. At 70, '
           f'71 and 72 % of the stiffness they do merge, at frictions {near}')
    if parts:
        summed = Case(without_rotation(parts.by_sums))
        pair = summed.soft_pair(1.0)
        why += (f'; and at 100 % too ({pair[0].growth_rate:+.0f} 1/s, {pair[0].frequency_hz:.0f} '
                'Hz) where integrals are sums over 15 x 43 nodes, as K09 eq. (40) reads, which '
                'counts the rim of the patch too much (docs/theory.md)')
    yield _said('25/26 merge without rotation, K 100 %', 'fig. 11', 'merge',
                f'{_gap(first, second):.1f} Hz apart at 0.42', _merged(first, second), why=why,
                known=all(_merged(*pair) for pair in softer))
    yield _said('such a merging at K 70 to 72 %', 'fig. 11', 'merge (100 %)',
                f'at friction {near}', all(_merged(*pair) for pair in softer),
                tolerance='softer K')
    grown = damped.pair(PADS, slow)[0].growth_rate
    yield _said('unlike radial damping of 25/26 destabilises', 'sec. 3.1', 'destabilises',
                f'{first.growth_rate:+.1f} to {grown:+.1f} 1/s', grown > first.growth_rate)
    low, high = (c.critical_friction(PADS) for c in (still, damped))
    soft = [c.critical_friction([mode.index for mode in softer[1]], stiffness=SOFTER[1])
            for c in (still, damped)]
    yield _said('radial term raises critical friction of 25/26', 'sec. 3.1', 'raises',
                f'{low:.3f} to {high:.3f}', high > low, known=soft[1] > soft[0],
                why='there is no merging here that it could put off; where there is one, at 71 % '
                f'of the stiffness, it does: from {soft[0]:.3f} to {soft[1]:.3f}')


def _speed(case: Case, record: Sweep) -> Iterator[Row]:
    """Fig. 15: growth rates over speed, friction by its law."""
    speeds, start = record.axes['rotor_speed'], case.by_law(SLOW)
    modes = complex_modes(case.model, start)
    place = case.of_torsion(modes, start).index - 1
    number = identify(case.model, start).identities[place].numbers[0]
    growth, edge = record.of(number).real, case.critical_speed((number,), SLOW)
    yield _said('torsion grows more at lower speed', 'fig. 15', 'rises',
                f'{growth[-1]:+.0f} to {growth[0]:+.0f} 1/s; unstable below {edge:.1f} rad/s',
                bool(np.all(np.diff(growth) < 0.0)))
    pads = np.fmax(*(record.of(number).real for number in PADS))
    top = int(np.argmax(pads))
    yield _said('pad pair grows more at lower speed', 'fig. 15', 'rises', f'{pads[-1]:+.1f} at 25 '
                f'to {pads[top]:+.1f} 1/s at {speeds[top]:g} rad/s',
                bool(np.all(np.diff(pads[speeds >= SLOW]) < 0.0)), tolerance='5..25 rad/s')
    strong = replace(without_rotation(case.model),
                     radial_dissipation=_times(10.0, case.model.radial_dissipation))
    locked = Case(strong).pair(PADS, case.at(SLOW))[0].growth_rate
    yield _said('... down to standstill', 'fig. 15', 'rises (range not in text)',
                f'falls to {pads[0]:+.1f} 1/s at {speeds[0]:g} rad/s', top == 0,
                known=locked < pads[top],
                why='the pair grows by unlike radial damping, in proportion to friction over '
                f'speed; below {speeds[top]:g} rad/s that is so large that it locks the radial '
                f'sliding instead: ten times that at 5 rad/s leaves {locked:+.1f} 1/s')
    for words, numbers in (('third', THIRD), ('fourth', added_pairs(case)[1][ADDED[0]])):
        edge = case.critical_speed(numbers, FAST)
        below = np.array([record.of(number).real[speeds < edge] for number in numbers])
        yield _said(f'{words} doublet stable at low speed', 'fig. 15', 'stable',
                    f'below {edge:.1f} rad/s', bool(below.size and np.all(below <= 0.0)))
    found = [[m.growth_rate for m in complex_modes(case.model, q).modes if m.kind == 'divergence']
             for q in (start, replace(start, friction_slope=0.0))]
    yield _said('divergence comes with the slope', 'fig. 15', 'appears', f'{len(found[0])} roots, '
                f'{max(found[0], default=0.0):.0f} 1/s; without slope {len(found[1])}',
                bool(found[0]) and not found[1])


def _torsion(case: Case, parts: Parts | None) -> Iterator[Row]:
    """Fig. 16 and section 3.2: in-plane torsion squeals by the negative slope alone."""
    place, start = case.model.names.index(TORSION), case.by_law(SLOW)
    size = max(float(np.abs(array[:, place]).max() / np.abs(array).max()) for array in (
        case.model.contact_stiffness, case.model.friction_couple) if array is not None)
    yield _said('torsion does not press on the pads', 'fig. 16', 'no column in A, B',
                f'{size:.0e} of the largest', size < 1e-12, tolerance='rounding')
    constant = {mu: case.of_torsion(complex_modes(case.model, q), q).growth_rate
                for mu in (FRICTION, 1.0) for q in [case.at(SLOW, friction=mu)]}
    yield _said('stable with constant friction', 'sec. 3.2', 'stable', ', '.join(
        f'{growth:+.1f} 1/s at {mu:g}' for mu, growth in constant.items()),
        max(constant.values()) < 0.0)
    mode = case.of_torsion(complex_modes(case.model, start), start)
    found = mechanisms(case.model, start, [mode])[0]
    without = {'negative_slope': np.nan, 'friction_couple': np.nan, **found.without}
    yield _said('squeals by negative slope, not coupling', 'fig. 16', 'negative slope',
                f'{mode.growth_rate:+.1f}; without slope {without["negative_slope"]:+.1f}, '
                f'without B {without["friction_couple"]:+.1f} 1/s',
                found.label == 'negative slope' and without['friction_couple'] > 0.0)
    if parts:
        follower = replace(parts.model, follower=operators.follower(parts.faces))
        change = max(abs(old.growth_rate - new.growth_rate) for q in (case.at(SLOW), case.at(FAST))
                     for old, new in zip(complex_modes(parts.model, q).modes, complex_modes(
                         follower, q).modes, strict=True) if old.kind == 'flutter')
        yield _said('in-plane follower force does not matter', 'sec. 2', 'insignificant',
                    f'{change:.2g} 1/s at most', change < 0.5, tolerance='0.5 1/s')


def _gap(first: Mode, second: Mode) -> float:
    return abs(first.frequency_hz - second.frequency_hz)


def _merged(first: Mode, second: Mode) -> bool:
    """Whether two roots differ more in growth than in frequency: past their merging."""
    return ((first.eigenvalue - second.eigenvalue)**2).real > 0.0


def _times(factor: float, array: FloatArray | None) -> FloatArray | None:
    return None if array is None else factor * array


def _names(found: Any) -> str:
    return ', '.join(f'{first}/{second}' for first, second in found)


WIDTHS = (28, 8, 13, 22, 9, 14)
HEAD = ('claim', 'source', 'K09', 'here', 'tolerance', 'verdict')


def as_text(result: Verification) -> str:
    """Return the table as text, 99 columns wide, and what is not reproduced with its reason."""
    lines = [*_cells(HEAD), '-' * 99]
    reasons: dict[tuple[str, str], list[str]] = {}
    for row in result.rows:
        lines += _cells((row.claim, row.source, row.paper, row.project, row.tolerance,
                         row.verdict))
        if row.reason:
            reasons.setdefault((row.verdict, row.reason), []).append(row.claim)
    lines += ['', 'Why']
    for (verdict, reason), claims in reasons.items():
        lines += _item(f'{"; ".join(claims)}: {verdict}. {reason[0].upper()}{reason[1:]}.')
    for text in result.skipped:
        lines += _item(f'Left out: {text}.')
    counts = ', '.join(f'{result.count(verdict)} {verdict}' for verdict in get_args(Verdict))
    return '\n'.join([*lines, '', f'Frequencies are reproduced within {EXACT:.1%}, within fit up '
                      f'to {FIT:.1%}.', f'{len(result.rows)} claims: {counts}; ' + (
                          'nothing unexpected' if result.passed else 'UNEXPECTED differences')])


def _item(text: str) -> list[str]:
    return textwrap.wrap(text, 99, initial_indent='- ', subsequent_indent='  ')


def _cells(texts: Sequence[str]) -> list[str]:
    columns = [textwrap.wrap(text, width) or [''] for text, width in zip(texts, WIDTHS,
                                                                         strict=True)]
    height = max(map(len, columns))
    return [' '.join((column[i] if i < len(column) else '').ljust(width)
                     for column, width in zip(columns, WIDTHS, strict=True)).rstrip()
            for i in range(height)]
