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


"""The handshake with a scheduler, with a timeout; log messages of Dask meanwhile."""

import asyncio
from collections.abc import Callable
import logging

from distributed.comm import connect
from distributed.security import Security

TICK = 0.25  # s, between looks at whether to go on


def answers(address: str, timeout: float, going_on: Callable[[], bool]) -> bool:
    """
    Connect to a scheduler; return whether it answered before the work was stopped.

    A client has no limit of its own where something takes its connection and never speaks.

    Parameters
    ----------
    address : str
        Of the scheduler.
    timeout : float
        For how long it may not answer [s].
    going_on : callable
        Of no arguments, called several times a second: whether to go on.

    Raises
    ------
    OSError, ValueError
        Where there is no answer, or no such address.

    """
    return asyncio.run(_answers(address, timeout, going_on))


async def _answers(address: str, timeout: float, going_on: Callable[[], bool]) -> bool:
    try:
        async with asyncio.timeout(timeout):
            handshake = asyncio.create_task(connect(
                address, timeout=timeout, **Security().get_connection_args('client')))
            while not (await asyncio.wait([handshake], timeout=TICK))[0]:
                if not going_on():
                    handshake.cancel()
                    return False
            await (await handshake).close()
            return True
    except TimeoutError:
        raise TimeoutError('no answer') from None


def silence() -> None:
    """Keep log messages of Dask off the terminal, by each logger's level: errors are raised."""
    for name in ('distributed', *logging.root.manager.loggerDict):
        if name.partition('.')[0] in ('distributed', 'tornado', 'asyncio'):
            logging.getLogger(name).setLevel(logging.CRITICAL)
