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

"""Recordings of any format: where they are found, and how they are opened."""

from collections.abc import Iterable, Iterator
import glob
import os
from pathlib import Path
import re

from squeal_core.common.errors import short_repr
from squeal_core.monitor.results.fleet_files import MANIFEST
from squeal_core.monitor.settings import MonitorSettings
from squeal_ros.recordings.bags.split_bags import is_one_bag, STORAGE
from squeal_ros.recordings.recording import Recording, RecordingError
from squeal_ros.recordings.signals.signals_file import Kind, Signals
from squeal_ros.recordings.signals.table_spec import ClockSpec

_TABLES = ('.csv', '.tsv')
_MEASUREMENTS = ('.mf4', '.mdf')
_FORMATS = (*STORAGE, '.bag', *_MEASUREMENTS, *_TABLES)
_TEXTS = (*_TABLES, '.txt', '.dat', '.asc', '.log', '.prn')  # of what is given by its name
_MOST_FILES = 1_000_000  # looked through in a folder
_RESULT = 'summary.json'  # what a replay writes beside its outputs


def open_recording(path: str | Path, settings: MonitorSettings, *,
                   types: str | Path | None = None, namespace: str = '/',
                   signals: Signals | None = None) -> Recording:
    """
    Open a recording of any format that is read.

    Parameters
    ----------
    path : path
        A file, or the folder of a rosbag2.
    settings : MonitorSettings
        Their inputs are read; with signals, those of `settings_with_signals`.
    types : path, optional
        Folder of .msg or .idl files, for messages whose definition a bag does not hold.
    namespace : str
        Where the settings' relative topics are in a bag.
    signals : Signals, optional
        What `read_signals` returns; tables need them.

    Raises
    ------
    SquealError
        For what cannot be read.

    """
    path = Path(path)
    kind = kind_of_path(path)
    check_signals(path, signals)
    given, signals = signals, signals and signals.of(source_kind(path))
    if kind == 'csv':
        from squeal_ros.recordings.tables.csv_recording import CsvRecording

        assert signals is not None
        return CsvRecording(path, settings, signals)
    if kind == 'mdf':
        from squeal_ros.recordings.tables.mdf_recording import MdfRecording

        assert signals is not None
        return MdfRecording(path, settings, signals)
    from squeal_ros.recordings.bags.bag_reader import Bag
    from squeal_ros.recordings.bags.bag_recording import BagRecording
    from squeal_ros.recordings.bags.message_definitions import MessageDefinitions

    about = [f'{given.path} names columns alone: inputs are read as the settings say'] if (
        given and not signals) else []
    return BagRecording(Bag(path, MessageDefinitions(types)), settings, namespace, signals, about)


def kind_of_path(path: Path) -> str:
    """Return the format of a recording, by its name: 'csv', 'mdf' or 'bag'."""
    name = path.name.casefold()
    if path.is_dir() or not name.endswith((*_TEXTS, *_MEASUREMENTS)):
        return 'bag'
    return 'csv' if name.endswith(_TEXTS) else 'mdf'


def source_kind(path: Path) -> Kind:
    """Return whether the inputs of a recording are columns (channels) or topics."""
    return 'topic' if kind_of_path(path) == 'bag' else 'column'


def check_signals(path: Path, signals: Signals | None) -> None:
    """Refuse a table without signals of its own, and a clock for a bag."""
    of_columns, own = source_kind(path) == 'column', signals and signals.of(source_kind(path))
    if of_columns and own is None:
        what = 'the signals name topics' if signals else 'nothing says which column is which input'
        raise RecordingError(path, f'is a table of columns, and {what}', 'run `squeal signals '
                             f'{path} -o SIGNALS.yaml`, check it, and give --signals SIGNALS.yaml')
    if own and not of_columns and own.clock != ClockSpec():
        raise RecordingError(f'{own.path}, clock', f'names more than a stamp, and {path} is a '
                             'bag', 'its times are those of recording and of headers')


def find_recordings(patterns: Iterable[str | Path]) -> list[Path]:
    """
    Return the recordings that files, folders and glob patterns name, each once, sorted.

    A folder of rosbag2 is one recording. In any other folder, and the folders in it, each file of
    a format that is read is one; results of replays are none.

    Parameters
    ----------
    patterns : iterable of paths
        A path that is there is taken as it is, whatever characters it has.

    Raises
    ------
    RecordingError
        For a pattern that nothing fits.

    """
    result: dict[Path, Path] = {}  # by where they are, so that no link names one twice
    for pattern in patterns:
        named = _named(str(pattern))
        inside = [recording for path in named for recording in _recordings_of(path)]
        if not inside:
            what = 'holds no recording' if named else 'is not there, and no file fits it'
            raise RecordingError(short_repr(str(pattern)), what,
                                 f'give files, folders or patterns of {", ".join(_FORMATS)}')
        for recording in inside:
            result.setdefault(recording.resolve(), recording)
    return sorted(result.values(), key=_natural)


def _named(pattern: str) -> list[Path]:
    """Return the paths that a path or a pattern names."""
    try:
        if os.path.lexists(pattern):
            return [Path(pattern)]
        return [path for path in map(Path, glob.glob(pattern, recursive=True))
                if path.is_dir() or path.name.endswith(_FORMATS)]
    except (OSError, ValueError, re.error):  # a NUL, a name too long
        return []


def _recordings_of(path: Path) -> Iterator[Path]:
    """Yield a file, a folder of rosbag2, or the recordings in any other folder."""
    if not path.is_dir():
        yield path
        return
    seen = 0
    for name, folders, files in os.walk(path):
        folder = Path(name)
        seen += len(files)
        if seen > _MOST_FILES:
            raise RecordingError(path, f'holds more than {_MOST_FILES} files',
                                 'give the folder of the recordings alone')
        if _RESULT in files or MANIFEST in files:
            folders.clear()
            continue
        folders[:] = [one for one in folders if not one.startswith('.')]
        results = {file.removesuffix(f'.{_RESULT}') for file in files if file.endswith(_RESULT)}
        readable = [file for file in files if file.endswith(_FORMATS)
                    and file.partition('.')[0] not in results]
        if 'metadata.yaml' in files or not results and is_one_bag(folder, readable):
            yield folder
        else:
            yield from (folder / file for file in readable)


def _natural(path: Path) -> list[tuple[int, str]]:
    """Return a key by which drive_10 comes after drive_9."""
    return [(int(part), '') if part.isdecimal() else (-1, part)
            for part in re.split(r'(\d+)', str(path)) if part]
