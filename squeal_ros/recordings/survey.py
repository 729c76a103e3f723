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

"""Contents of a recording of any format."""

from pathlib import Path

from squeal_ros.recordings.recording import RecordingError
from squeal_ros.recordings.recording_files import find_recordings, kind_of_path
from squeal_ros.recordings.signals.contents import Contents


def contents_of(path: str | Path, types: str | Path | None = None) -> Contents:
    """
    Return the contents of a recording.

    Parameters
    ----------
    path : path
        Of one, or of a folder that holds one.
    types : path, optional
        Folder of definitions for messages whose definition a bag does not hold.

    Raises
    ------
    SquealError
        For what cannot be read.

    """
    result = find_recordings([path])
    if len(result) > 1:
        raise RecordingError(path, f'holds {len(result)} recordings, the first {result[0]}',
                             'give one of them; the file of signals serves all that are alike')
    (path,) = result
    kind = kind_of_path(path)
    if kind == 'csv':
        from squeal_ros.recordings.tables.csv_contents import csv_contents

        return csv_contents(path)
    if kind == 'mdf':
        from squeal_ros.recordings.tables.mdf_contents import mdf_contents

        return mdf_contents(path)
    from squeal_ros.recordings.bags.bag_contents import bag_contents

    return bag_contents(path, types)
