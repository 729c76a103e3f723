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


"""Task of a fleet's worker: digest and result of a recording, whole or not at all."""

from dataclasses import replace
from functools import lru_cache
import hashlib
import json
from pathlib import Path
import pickle
from typing import Any, NamedTuple

from squeal_core.common.errors import LocatedError, SquealError
from squeal_core.common.output import OutputError, OutputFiles
from squeal_core.monitor.results.result_files import ResultPaths, SOURCE_FILES
from squeal_core.monitor.results.result_summary import file_hash
from squeal_ros.recordings.recording_files import kind_of_path
from squeal_ros.recordings.replay.evaluation_process import write_replay
from squeal_ros.recordings.replay.replay_batch import ReplayTask

_KEY = 32  # hexadecimal digits of SHA-256 that name a result


class FleetError(LocatedError):
    """A fleet that cannot be evaluated."""


class Evaluated(NamedTuple):
    """Outcome of a recording: its result and SHA-256, or the error; whether written now."""

    path: str
    sha256: str
    error: str = ''
    written: bool = False


def recording_digest(path: str) -> str:
    """Return the SHA-256 of a recording; of what is no file, and has no content, of its path."""
    at = Path(path)
    if at.is_file() or at.is_dir():
        return file_hash(at)[0]
    return hashlib.sha256(path.encode(errors='surrogateescape')).hexdigest()


def evaluate_recording(packed: bytes, path: str, target: str, expected: str) -> Evaluated:
    """
    Write the result of a recording into its folder, if it is not there yet.

    Parameters
    ----------
    packed : bytes
        The `ReplayTask`, pickled.
    path, target : str
        Of the recording, and of the folder of its result.
    expected : str
        SHA-256 of the result where one is there; another one is written anew. '': not known.

    Raises
    ------
    Exception
        For what may go well another time; errors of the recording are returned.

    """
    folder = Path(target)
    if folder.is_dir() and expected in ('', digest := file_hash(folder)[0]):
        return Evaluated(target, digest)
    try:
        task = _task(packed).of(Path(path))
        replay = task.replay(Path(path), lambda _: False)
        with OutputFiles(overwrite=True) as files:
            partial = files.add(folder, folder=True).partial
            write_replay(replay, task.outputs(ResultPaths.in_folder(partial)), parallel=False)
    except OutputError:
        raise
    except SquealError as error:
        return Evaluated(path, '', str(error))
    return Evaluated(target, file_hash(folder)[0], written=True)


@lru_cache(maxsize=4)
def _task(packed: bytes) -> ReplayTask:
    """Return the task, if this worker has the software and files that the results are keyed by."""
    given: ReplayTask = pickle.loads(packed)
    stated, own = given.sources, replace(given).sources
    differing = [key for key in ('software', *SOURCE_FILES) if stated[key] != own[key]]
    if differing:
        raise FleetError('a worker', f'has another {", ".join(differing)} than the client '
                         f'({_short(own, differing)} against {_short(stated, differing)})',
                         'give client and workers the same installation and files')
    return given


def _short(sources: dict[str, Any], keys: list[str]) -> str:
    return json.dumps({key: sources[key] for key in keys})[:300]


def content_key(task: ReplayTask, path: Path, digest: str) -> str:
    """
    Return the name of a result: of all that decides what is in it, and of no path.

    Parameters
    ----------
    task : ReplayTask
        What is done with the recording.
    path : Path
        Of the recording.
    digest : str
        SHA-256 of the recording.

    """
    own = task.of(path)
    settings = json.loads(own.sources['settings']['yaml'])
    for key in ('model', 'table', 'growth_emulator', 'calibration'):
        settings[key] = ''  # their contents are keyed
    content = {
        'recording': digest, 'kind': kind_of_path(path), 'settings': settings,
        'namespace': task.namespace, 'span': repr(task.span), 'tables': task.tables,
        'software': own.sources['software'],
        **{key: (own.sources[key] or {}).get('sha256') for key in SOURCE_FILES}}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:_KEY]
