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


"""Files of a simulation: sound, events, levels of the modes, and how they came to be."""

import csv
from dataclasses import asdict
import json
from pathlib import Path
import re
from typing import Any

import numpy as np
from squeal_core.common.output import check_target, make_folder, OutputFiles
from squeal_core.simulation.levels import SimulatedEvent
from squeal_core.simulation.microphone import AUDIO_RATE
from squeal_core.simulation.simulated_sound import SimulationResult

FULL_SCALE = 20.0  # Pa at a sample of 1.0: the peak of a tone of 117 dB


class SimulationFiles:
    """
    The files of one simulation in a folder.

    `microphone_BRAKE.wav` (floats, 1.0 = 20 Pa), `events.csv`, `simulation.json`, and, where
    they are wanted, the levels of all modes in `levels.npz`.

    Parameters
    ----------
    folder : path
        Made where it is not there.
    brakes : tuple of str
    levels : bool
        Whether the levels of all modes are wanted.

    """

    def __init__(self, folder: str | Path, brakes: tuple[str, ...], *, levels: bool) -> None:
        self.folder, self._brakes = Path(folder), brakes
        self.sounds = [self.folder / f'microphone_{re.sub(r"[^A-Za-z0-9_-]", "_", name)}.wav'
                       for name in brakes]
        self.events, self.about = self.folder / 'events.csv', self.folder / 'simulation.json'
        self.levels = self.folder / 'levels.npz' if levels else None

    @property
    def paths(self) -> list[Path]:
        """Return all paths."""
        return [*self.sounds, self.events, self.about, *([self.levels] if self.levels else [])]

    def prepare(self, *, overwrite: bool) -> None:
        """
        Refuse, before the work, what could not be written.

        Raises
        ------
        OutputError
            For files that are there, or a folder that cannot be written to.

        """
        make_folder(self.folder)
        for path in self.paths:
            check_target(path, overwrite=overwrite)

    def write(self, result: SimulationResult, about: dict[str, Any], *, overwrite: bool) -> None:
        """Write all files, or none; `about` goes into `simulation.json`."""
        from scipy.io import wavfile
        with OutputFiles(overwrite=overwrite) as files:
            for path, sound in zip(self.sounds, result.sound.T, strict=True):
                wavfile.write(files.add(path).partial, AUDIO_RATE,
                              (sound / FULL_SCALE).astype(np.float32))
            with files.add(self.events).partial.open('w', newline='', encoding='utf-8') as file:
                _write_events(file, result.events)
            files.add(self.about).partial.write_text(json.dumps(
                {'full_scale_pa': FULL_SCALE, 'sample_rate_hz': AUDIO_RATE, **about}, indent=1)
                + '\n', encoding='utf-8')
            if self.levels:
                with files.add(self.levels).partial.open('wb') as archive:
                    np.savez_compressed(
                        archive, brakes=np.array(result.brakes), sliding=result.sliding,
                        **asdict(result.levels))


def _write_events(file: Any, events: list[SimulatedEvent]) -> None:
    writer = csv.writer(file, lineterminator='\n')
    writer.writerow(('time_s', 'brake', 'frequency_hz', 'level_db', 'end_s', 'mode'))
    writer.writerows((f'{event.start:.4f}', event.brake, f'{event.frequency_hz:.2f}',
                      f'{event.level_db:.2f}', f'{event.end:.4f}', event.mode)
                     for event in events)
