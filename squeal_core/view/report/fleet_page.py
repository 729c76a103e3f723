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


"""The page of a fleet: by vehicle, brake, mileage, date and operating region, and recordings."""

from collections.abc import Mapping

from squeal_core.view.report.fleet_charts import region_map, share_bars
from squeal_core.view.report.fleet_groups import FleetData
from squeal_core.view.report.fleet_sections import (
    group_table,
    known_section,
    recordings_section,
    region_table,
)
from squeal_core.view.report.page import Page

_NO_VEHICLE = ('Not known: the recordings are in no folders of vehicles; give `squeal fleet '
               '--vehicles`.')
_NO_MILEAGE = 'Not known: no recording has a mileage; give `squeal fleet --vehicles`.'
_NO_DATE = 'Not known: no clock of a recording has a date.'


def fleet_page(data: FleetData, pages: Mapping[str, str], how: str) -> str:
    """
    Return the page of a fleet.

    Parameters
    ----------
    data : FleetData
        What is shown.
    pages : mapping
        Where the page of a result is, relative to this one; of some or all recordings.
    how : str
        How the other pages are made.

    """
    page = Page()
    vehicles = {} if set(data.vehicles) <= {''} else data.vehicles
    page.add('known', '1 What is known', *known_section(data))
    page.add('vehicles', '2 Vehicles', page.draw(share_bars(
        vehicles, name='by-vehicle', title='By vehicle, worst first', axis='vehicle',
        unknown=_NO_VEHICLE)), *group_table(data.vehicles, 'vehicle', 'recordings'))
    page.add('brakes', '3 Brakes', page.draw(share_bars(
        data.brakes, name='by-brake', title='By brake', axis='brake',
        unknown='Nothing was evaluated.')), *group_table(data.brakes, 'brake', 'brakes'))
    page.add('time', '4 Mileage and date', page.draw(
        share_bars(data.mileage, name='by-mileage', title='Over mileage', axis='mileage  km',
                   unknown=_NO_MILEAGE, wide=False),
        share_bars(data.dates, name='by-date', title='Over date', axis='date (UTC)',
                   unknown=_NO_DATE, wide=False)))
    page.add('regions', '5 Operating regions', page.draw(region_map(data.regions)),
             *region_table(data))
    page.add('recordings', '6 Recordings', *recordings_section(data, pages, how))
    return page.whole(f'Squeal in the fleet: {data.folder.path.resolve().name}')
