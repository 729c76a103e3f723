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
Nonlinear transients of brakes: contact that opens, exact friction direction, noise, sound.

    contact_points    relative mode shapes under the model's integrals over the contact
    contact           contact and friction forces, not linearised
    history           where brakes operate over time
    transient         the integrator: exact modal oscillators between kicks of the contact
    modal_noise       modes of the closed contact, and noise that holds each at its floor
    abutment          what keeps pads without stiffness in plane where they are
    microphone        sound pressure beside the disc
    levels            levels and pitches of modes, squeal events
    simulated_sound   all together: `simulate`
    first_events      which of many brake applications squeal
    simulation_files  WAV, events, levels
"""

from squeal_core.simulation.contact import NonlinearContact
from squeal_core.simulation.contact_points import contact_points
from squeal_core.simulation.first_events import first_events
from squeal_core.simulation.history import OperatingHistory
from squeal_core.simulation.levels import ModalLevels, SimulatedEvent
from squeal_core.simulation.simulated_sound import simulate, SimulationResult
from squeal_core.simulation.transient import Transient
from squeal_core.simulation.transient_block import TransientBlock

__all__ = ['contact_points', 'first_events', 'ModalLevels', 'NonlinearContact', 'OperatingHistory',
           'SimulatedEvent', 'simulate', 'SimulationResult', 'Transient', 'TransientBlock']
