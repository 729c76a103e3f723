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

"""Markers of the worst unstable mode: off by default, latched, wiped when they no longer hold."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs rclpy')
pytest.importorskip('visualization_msgs', reason='needs visualization_msgs')

from rclpy.parameter import Parameter  # noqa: E402
from squeal_core import BrakeModel  # noqa: E402
from squeal_core.stability.eigensolution import complex_modes  # noqa: E402
from squeal_core.stability.eigenvectors import mode_vectors  # noqa: E402
from support.node_outputs import LATCHED  # noqa: E402, I100
from support.node_runs import vehicle  # noqa: E402
from support.vehicle import Vehicle  # noqa: E402
from visualization_msgs.msg import Marker, MarkerArray  # noqa: E402

TOPIC = '/squeal_monitor/fl/mode_shape'


def watch(car: Vehicle) -> list[Any]:
    heard: list[Any] = []
    car.node.create_subscription(MarkerArray, TOPIC, heard.append, LATCHED)
    return heard


def test_off_by_default() -> None:
    with vehicle() as car:
        car.until(lambda: car.risk > 0.99 and car.figures.get('mode_shapes') == 'off')
        assert not car.monitor.get_publishers_info_by_topic(TOPIC)


def test_the_worst_mode_is_drawn_and_wiped(kang: BrakeModel) -> None:
    with vehicle(mode_shapes=True, mode_shape_size=0.004,
                 mode_shape_frame='car/{brake}_disc') as car:
        heard = watch(car)
        car.until(lambda: bool(heard) and len(heard[-1].markers) == 3)
        assert car.figures['mode_shapes'] == 'published'
        markers = heard[-1].markers
        assert [m.ns for m in markers] == ['pad 1', 'disc', 'pad 2']
        assert kang.surface is not None
        point = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
        worst = next(m for m in complex_modes(kang, point).unstable if m.kind == 'flutter')
        assert markers[0].text.startswith(f'{worst.frequency_hz:.0f} Hz')
        vector = mode_vectors(kang, point, worst.eigenvalue).right
        points, _ = kang.surface.displaced(vector, 0.004)
        start = 0
        for marker, patch in zip(markers, kang.surface.patches, strict=True):
            assert (marker.type, marker.action) == (Marker.TRIANGLE_LIST, Marker.ADD)
            assert marker.header.frame_id == 'car/fl_disc'
            assert marker.scale.x == 1.0
            assert len(marker.points) == len(marker.colors) == 3 * len(list(patch.triangles()))
            drawn = np.unique([(p.x, p.y, p.z) for p in marker.points], axis=0)
            expected = np.unique(points[start:start + patch.size], axis=0)
            np.testing.assert_allclose(drawn, expected, atol=1e-9)
            start += patch.size
        late = watch(car)
        car.until(lambda: len(late) > 0)  # latched
        car.pressure = 0.0
        car.until(lambda: [m.action for m in heard[-1].markers] == [Marker.DELETEALL])
        count = len(heard)
        done = car.monitor.health.ticks_done
        car.until(lambda: car.monitor.health.ticks_done > done + 30)
        assert len(heard) == count  # said once


def test_a_monitor_that_stops_leaves_no_picture() -> None:
    with vehicle(mode_shapes=True) as car:
        heard = watch(car)
        car.until(lambda: bool(heard) and len(heard[-1].markers) == 3)
        car.monitor.trigger_deactivate()
        car.until(lambda: [m.action for m in heard[-1].markers] == [Marker.DELETEALL])


def test_a_model_without_shapes_says_so(kang: BrakeModel, tmp_path: Path) -> None:
    replace(kang, surface=None).save(tmp_path / 'plain.npz')
    with vehicle(mode_shapes=True, model=str(tmp_path / 'plain.npz')) as car:
        car.until(lambda: car.risk > 0.99
                  and 'no shapes in this model' in car.figures.get('mode_shapes', ''))
        assert car.monitor.set_parameters([Parameter('mode_shape_size', value=0.1)])[0].successful
