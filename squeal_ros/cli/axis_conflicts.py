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

"""Axes and options that no point would depend on: refused, not computed."""

import argparse
from collections.abc import Collection

from squeal_core.common.errors import SquealError
from squeal_core.stability.parameter_paths import Law

LOADS = ('preload', 'pressure', 'contact_pressure')


def refuse_conflicts(options: argparse.Namespace, swept: Collection[str], searched: str = '', *,
                     stiffness_table: bool) -> None:
    """
    Refuse loads beside each other, and numbers of the description that something else overrules.

    Parameters
    ----------
    options : namespace
        As given: before defaults are filled in.
    swept : collection of str
        Axes.
    searched : str
        What a critical value is searched along, too.
    stiffness_table : bool
        Whether the brake's contact stiffness follows a table.

    Raises
    ------
    SquealError
        What has no effect, why, and what to leave out or add.

    """
    load = next((name for name in swept if name in LOADS), '')
    given = next((name for name in ('preload', 'pressure')
                  if getattr(options, name) is not None), '')
    # a given contact stiffness holds at the given load, and follows the table from there
    anchored = stiffness_table and options.contact_stiffness is not None
    if load and given and given != load and not anchored:
        raise SquealError(f'--{given}: has no effect beside --over {load}, they are one load; '
                          'leave one of them out')
    if options.friction_law and 'friction_slope' in swept:
        raise SquealError('--friction-law: has no effect on the slope beside --over '
                          'friction_slope; leave one of them out')
    for path in (*swept, searched):
        why = (_stiffness(options, swept, stiffness_table) if path.startswith('contact.stiffness_')
               else _friction(options, swept) if path.startswith('friction.')
               else _caliper(options, load) if path.startswith('caliper.') else '')
        if why:
            option = '--over' if path in swept else '--parameter'
            raise SquealError(f'{option} {path}: has no effect, {why}')


def refuse_without_rotation(options: argparse.Namespace, parameter: str, swept: Collection[str],
                            law: Law, *, load_counts: bool) -> None:
    """
    Refuse a parameter that acts through the terms of rotation alone, where these are left out.

    Parameters
    ----------
    options : namespace
        Of the command.
    parameter : str
        An axis, or what a critical value is searched along.
    swept : collection of str
        Axes.
    law : bool or 'slope'
        What follows the friction law along it.
    load_counts : bool
        Whether contact stiffness follows a table, or there is a follower force.

    Raises
    ------
    SquealError
        With the parameter, why it has no effect, and what to leave out.

    """
    by_load = parameter in LOADS or parameter.startswith('caliper.')
    by_slope = parameter == 'friction_slope' or (
        parameter.startswith('friction.')
        and ('friction' in swept or options.friction is not None))
    if options.without_rotation and (by_slope or (by_load and not load_counts) or (
            parameter == 'rotor_speed' and law is not True)):
        raise SquealError(
            f'{"--over" if parameter in swept else "--parameter"} {parameter}: has no effect, as '
            '--without-rotation leaves out the gyroscopic, radial and slope terms, through which '
            'alone it acts; leave one of them out')


def _stiffness(options: argparse.Namespace, swept: Collection[str], table: bool) -> str:
    if 'contact_stiffness' in swept:
        return 'as --over contact_stiffness sets the stiffness; leave one of them out'
    if options.contact_stiffness is not None:
        return 'as --contact-stiffness sets the stiffness; leave one of them out'
    return ('as contact.stiffness_table sets the stiffness; take the table out of the '
            'description, or sweep contact_stiffness') if table else ''


def _friction(options: argparse.Namespace, swept: Collection[str]) -> str:
    """Return the option that keeps friction and its slope from following the law, with remedy."""
    by = ('--over friction' if 'friction' in swept else
          '--friction' if options.friction is not None else '')
    if not by or (options.friction_law and 'friction_slope' not in swept):
        return ''
    law = '' if {'friction_slope'} & {*swept} or options.friction_slope is not None else (
        ', or add --friction-law for its slope')
    return f'as {by} takes the place of the friction law; leave one of them out{law}'


def _caliper(options: argparse.Namespace, load: str) -> str:
    """Return the load that keeps a brake pressure from being used, with remedy."""
    if load == 'pressure' or (not load and options.pressure is not None):
        return ''
    by = f'--over {load}' if load else 'a preload'
    other = '--over pressure in its place' if load else '--pressure PA'
    return f'as the load is {by} and no brake pressure; give {other}'
