"""Bag in, assessments out: the monitor of the node, on the bag's time."""

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from squeal_core.brake_model import BrakeModel
from squeal_core.history import CsvWriter, Row, row_of
from squeal_core.monitor import Assessment, VehicleMonitor
from squeal_core.settings import MonitorSettings
from squeal_ros import messages
from squeal_ros.bag import BagMessages, BagWriter, read_bag
from squeal_ros.signals import Router

# a longer silence of all inputs is assessed for its first part only: they are stale by then
_LONGEST_SILENCE = 10_000_000_000


def replay(bag: str | Path, settings: MonitorSettings, model: BrakeModel, *,
           namespace: str = '/', router: Router | None = None) -> Iterator[tuple[Assessment, ...]]:
    """Yield the assessments of every tick over a bag, on the same grid of times as the node.

    Parameters
    ----------
    bag : path
    settings : MonitorSettings
    model : BrakeModel
    namespace : str
        Where the settings' relative topics are in the bag.
    router : Router, optional
        Give one to look at its `problems` afterwards.
    """
    router = router or Router.of(settings)
    monitor = VehicleMonitor(settings, model)
    topics = {absolute(topic, namespace): topic for topic in router.types}
    period, tick = settings.period, 0
    for topic, time, message in read_bag(bag, topics):
        first = -(-time // period)
        if tick == 0:
            tick = first
        if time < (tick - 1) * period:  # the bag's clock went back
            monitor.reset()
            tick = first
        silence = min(first, tick + _LONGEST_SILENCE // period)
        while tick < silence:
            yield monitor.assess(tick * period)
            tick += 1
        tick = max(tick, first)
        for brake, signal, sample in router.samples(topics[topic], message, time):
            monitor.receive(brake, signal, sample)
    if tick:
        yield monitor.assess(tick * period)


def absolute(topic: str, namespace: str) -> str:
    """Return a topic as a bag names it."""
    return topic if topic.startswith('/') else f'{namespace.rstrip("/")}/{topic}'


@dataclass
class Outputs:
    """Writes what the node publishes as a bag, and a table beside it as CSV."""

    path: Path
    settings: MonitorSettings
    node: str = '/squeal_monitor'
    rows: list[Row] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._levels = messages.Levels(self.settings)

    @property
    def csv_path(self) -> Path:
        return self.path.with_suffix('.csv')

    def write(self, ticks: Iterator[tuple[Assessment, ...]]) -> None:
        """Write all ticks; keeps the rows for whoever looks at them next."""
        partial = self.csv_path.with_name(f'{self.csv_path.name}.part')
        with ExitStack() as stack:
            bag = stack.enter_context(BagWriter(self.path))
            stack.callback(partial.unlink, missing_ok=True)
            with partial.open('w', encoding='utf-8', newline='') as file:
                table = CsvWriter(file)
                for done, assessments in enumerate(ticks, start=1):
                    self._write_tick(bag, table, assessments, done)
            partial.replace(self.csv_path)

    def _write_tick(self, bag: BagWriter, table: CsvWriter, assessments: tuple[Assessment, ...],
                    done: int) -> None:
        library, levels = BagMessages(), self._levels.of(assessments)
        for assessment in assessments:
            row = row_of(assessment)
            self.rows.append(row)
            table.write(row)
            for name, message in messages.brake_messages(library, assessment):
                bag.write(f'{self.node}/{assessment.brake}/{name}', messages.TYPES[name],
                          assessment.time, message)
        bag.write('/diagnostics', messages.DIAGNOSTICS_TYPE, assessments[0].time,
                  messages.diagnostics(library, self.node.lstrip('/'), assessments,
                                       levels, messages.NodeStatus({'ticks_done': done})))
