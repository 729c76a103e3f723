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

"""The worst unstable mode of each brake as markers, for RViz and Foxglove."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.surface_shapes import Patch, SurfaceShapes
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_monitor import Assessment
from squeal_core.stability.eigensolution import Mode
from squeal_core.stability.eigenvectors import mode_vectors
from squeal_ros.node.messages import MARKERS_TYPE, MessageLibrary

_PERIOD = 1_000_000_000  # ns of steady time between two sets of markers of a brake, at least
_ADD, _DELETE_ALL, _TRIANGLES = 0, 3, 11  # visualization_msgs/Marker
_COLOURS = 32


class ModeShapes:
    """
    Draws now and then, a brake a tick at most, and wipes what no longer holds.

    Parameters
    ----------
    library : MessageLibrary
    model : BrakeModel
    settings : MonitorSettings
    publish : callable
        Given brake and MarkerArray.

    """

    def __init__(self, library: MessageLibrary, model: BrakeModel, settings: MonitorSettings,
                 publish: Callable[[str, Any], None]) -> None:
        self._model, self._publish = model, publish
        self._settings = settings
        self._painter = _Painter(library)
        self._drawn: dict[str, int] = {}
        self._blank: set[str] = set()

    @property
    def status(self) -> str:
        """Return the status of the markers, in words."""
        return 'published' if self._model.surface else 'no shapes in this model: build it again'

    def update_settings(self, settings: MonitorSettings) -> None:
        """Apply other settings from the next markers on."""
        self._settings = settings

    def update(self, assessments: Sequence[Assessment], steady: int) -> None:
        """Publish the markers that have waited longest, if due by the steady time [ns]."""
        if self._model.surface is None:
            return
        waiting = [a for a in assessments if self._may_draw(a, steady)]
        if waiting:
            longest = min(waiting, key=lambda a: self._drawn.get(a.brake, 0))
            self._drawn[longest.brake] = steady
            self._publish(longest.brake, self._markers(longest, self._model.surface))

    def wipe(self) -> None:
        """Publish empty markers where there are others: the monitor stops."""
        for brake in set(self._drawn) - self._blank:
            self._publish(brake, self._painter.blank())
        self._blank.update(self._drawn)

    def _may_draw(self, assessment: Assessment, steady: int) -> bool:
        if not assessment.flutter and assessment.brake in self._blank:
            return False
        return steady - self._drawn.get(assessment.brake, steady - _PERIOD) >= _PERIOD

    def _markers(self, assessment: Assessment, surface: SurfaceShapes) -> Any:
        if not assessment.flutter or assessment.point is None:
            self._blank.add(assessment.brake)
            return self._painter.blank()
        self._blank.discard(assessment.brake)
        mode: Mode = assessment.flutter[0]
        vector = mode_vectors(self._model, assessment.point, mode.eigenvalue).right
        points, amplitude = surface.displaced(vector, self._settings.mode_shape_size)
        frame = self._settings.mode_shape_frame
        for word in ('<brake>', '{brake}'):  # the latter in settings of earlier versions
            frame = frame.replace(word, assessment.brake)
        return self._painter.markers(assessment, mode, frame, surface.patches, points, amplitude)


class _Painter:
    """Makes marker messages; colours are made once."""

    def __init__(self, library: MessageLibrary) -> None:
        self._library = library
        colour = library.type('std_msgs/msg/ColorRGBA')
        self._colours = [colour(r=x, g=0.25, b=1.0 - x, a=1.0)
                         for x in np.linspace(0.0, 1.0, _COLOURS).tolist()]

    def blank(self) -> Any:
        return self._array([self._library.type('visualization_msgs/msg/Marker')(
            action=_DELETE_ALL)])

    def markers(self, assessment: Assessment, mode: Mode, frame: str, patches: Sequence[Patch],
                points: FloatArray, amplitude: FloatArray) -> Any:
        seconds, nanoseconds = divmod(assessment.time, 1_000_000_000)
        header = self._library.type('std_msgs/msg/Header')(
            stamp=self._library.type('builtin_interfaces/msg/Time')(
                sec=seconds, nanosec=nanoseconds), frame_id=frame)
        text = f'{mode.frequency_hz:.0f} Hz, {mode.growth_rate:+.1f} 1/s'
        return self._array(list(self._markers(header, text, patches, points, amplitude)))

    def _array(self, markers: list[Any]) -> Any:
        return self._library.type(MARKERS_TYPE)(markers=markers)

    def _markers(self, header: Any, text: str, patches: Sequence[Patch], points: FloatArray,
                 amplitude: FloatArray) -> Iterator[Any]:
        point = self._library.type('geometry_msgs/msg/Point')
        marker = self._library.type('visualization_msgs/msg/Marker')
        vector = self._library.type('geometry_msgs/msg/Vector3')
        places = [point(x=x, y=y, z=z) for x, y, z in points.tolist()]
        shades = np.round(amplitude * (_COLOURS - 1)).astype(int).tolist()
        start = 0
        for number, patch in enumerate(patches):
            corners = [start + i for triangle in patch.triangles() for i in triangle]
            yield marker(
                header=header, ns=patch.name, id=number, type=_TRIANGLES, action=_ADD, text=text,
                scale=vector(x=1.0, y=1.0, z=1.0), color=self._colours[0],
                points=[places[i] for i in corners],
                colors=[self._colours[shades[i]] for i in corners])
            start += patch.size
