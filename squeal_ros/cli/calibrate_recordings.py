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

"""Recordings that a calibration is given, and their brake applications that were listened to."""

import argparse
from dataclasses import dataclass, field
from pathlib import Path

from squeal_core.calibration.applications import BrakeApplication
from squeal_core.common.errors import did_you_mean, SquealError
from squeal_core.sound.listening import Listening
from squeal_ros.cli.console import warn
from squeal_ros.cli.replay_commands import found_recordings, monitor_task
from squeal_ros.recordings.recording import RecordingError
from squeal_ros.recordings.recording_files import check_signals
from squeal_ros.recordings.replay.brake_applications import collect_applications
from squeal_ros.recordings.replay.replay_batch import BatchRecording, plan_batch, ReplayTask


@dataclass
class ListenedApplications:
    """Brake applications of all recordings, and where times of their events count from [s]."""

    applications: list[BrakeApplication] = field(default_factory=list)
    zero: dict[str, float] = field(default_factory=dict)
    ticks: int = 0


@dataclass(frozen=True)
class GivenRecordings:
    """
    Recordings of any format and number, read as `squeal replay` reads them.

    Parameters
    ----------
    task : ReplayTask
        How they are read.
    batch : list of BatchRecording
        With the names that a replay gives their results.

    """

    task: ReplayTask
    batch: list[BatchRecording]

    @classmethod
    def of(cls, options: argparse.Namespace) -> 'GivenRecordings':
        """Return the recordings that files, folders and patterns name, without their events."""
        task, heard = monitor_task(options), Path(options.events or options.sound).resolve()
        recordings = [one for one in found_recordings(options, task) if one.resolve() != heard]
        if not recordings:
            raise RecordingError(heard, 'is the table of events', 'give recordings besides')
        for path in recordings:
            check_signals(path, task.signals)  # before its brakes are looked for in the events
        return cls(task, plan_batch(recordings, Path()))

    @property
    def brakes(self) -> list[str]:
        """Return the brakes of the settings, or of the signals in place of theirs."""
        return list(dict.fromkeys(brake.name for one in self.batch
                                  for brake in self.task.of(one.path).settings.brakes))

    def listened(self, options: argparse.Namespace, heard: Listening) -> ListenedApplications:
        """Return the applications that were listened to."""
        listened, read = self.listened_brakes(options.brakes), ListenedApplications()
        for one in self.batch:
            replay = self.task.of(one.path).replay(one.path, lambda _: False)
            collected = collect_applications(replay, one.name)
            for finding in replay.findings:
                warn(f'{one.path}: {finding.what}; {finding.remedy}')
            zero = (collected.start if options.from_start else 0.0) + options.offset
            low, high = (None if end is None else zero + end
                         for end in (options.from_, options.to))
            read.zero[one.name] = zero
            read.ticks += collected.ticks
            read.applications += [
                it for it in collected.applications if it.brake in listened
                and heard.covers(one.name, it.time[0] - zero, it.time[-1] - zero)
                and (low is None or it.time[0] >= low) and (high is None or it.time[-1] <= high)]
        if not read.applications:
            raise SquealError(f'{", ".join(options.recordings)}: no brake slides under load in '
                              'what was listened to; check recordings, --from, --to, --brakes and '
                              'the clock of the sound')
        return read

    def of_all_brakes(self, given: str | None) -> list[str]:
        """Return the remark on brakes that --brakes does not name."""
        heard = self.listened_brakes(given)
        others = [name for name in self.brakes if name not in heard]
        return [f'listened to {", ".join(heard)} only; node and replay use the calibration for '
                f'every brake of the model, {", ".join(others)} too'] if others else []

    def listened_brakes(self, given: str | None) -> list[str]:
        """Return the brakes that --brakes names; by default all."""
        known = self.brakes
        names = given.split(',') if given else known
        for name in names:
            if name not in known:
                raise SquealError(f'--brakes: {name!r} is none of the settings; give some of '
                                  f'{",".join(known)}{did_you_mean(name, known)}')
        return names
