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

"""
Write the sample recording of the tutorials, docs/sample: brake signals and a sound; synthetic.

`squeal drive` writes the signals, of the schedule drive.yaml. The sound is road noise at the speed
of that drive, squeal of the front left brake and a horn. The squeal is where the model expects it
but for two applications: the stop at the start is silent, the sixth of seven squeals. So there is
a false alarm and a miss to find.

Run: python examples/sample_recording.py [FOLDER] (default: docs/sample)
"""

from pathlib import Path
import sys

import numpy as np
import soundfile

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / 'test'))
from squeal_core import BrakeModel  # noqa: E402
from squeal_core.common.arrays import FloatArray  # noqa: E402
from squeal_ros.cli.drive_signals import drive_and_vehicle, signals_of  # noqa: E402
from squeal_ros.cli.main import main as squeal  # noqa: E402
from support.sounds import horn, road_noise, Squeal  # noqa: E402, I100

MODEL = 'kang2009_damped'
RATE = 8000  # Hz, of the sound: small, and enough for squeal up to 4 kHz
FULL_SCALE = 20.0  # Pa, as `squeal simulate` has it
NOISE = 0.012  # Pa, root mean square in the squeal band at 20 m/s
LEVEL = 34.0  # dB over that
SQUEALS = ((11.2, 12.4, 1383.0), (13.5, 14.9, 1381.0), (19.1, 19.9, 1383.0), (21.3, 22.9, 1382.0))
HORN = 16.9, 17.7  # s


def sound() -> FloatArray:
    """Return the sound, of full scale."""
    drive, vehicle = drive_and_vehicle(str(ROOT / 'docs' / 'sample' / 'drive.yaml'), 'midsize')
    signals = signals_of(drive, vehicle, BrakeModel.load(MODEL), rate=5.0)
    time = np.arange(round(RATE * signals.time[-1])) / RATE
    speed = np.interp(time, signals.time, signals.vehicle_speed)
    whole = NOISE * road_noise(np.random.default_rng(17), time, 2.0 + speed)
    for start, end, hertz in SQUEALS:
        tone = Squeal(start, end, hertz, 0.0, glide=4.0, beat=3.0).sound(time, 0.49 * RATE)
        whole += NOISE * 10.0 ** (0.05 * LEVEL) * tone
    return np.asarray((whole + horn(time, *HORN, 0.2)) / FULL_SCALE)


def main() -> int:
    """Write both files."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / 'docs' / 'sample'
    soundfile.write(folder / 'drive.flac', sound(), RATE, subtype='PCM_16')
    return squeal(['drive', str(ROOT / 'docs' / 'sample' / 'drive.yaml'), '--model', MODEL,
                   '--offline', '--rate', '5', '--record', str(folder / 'drive.mcap'), '--force'])


if __name__ == '__main__':
    sys.exit(main())
