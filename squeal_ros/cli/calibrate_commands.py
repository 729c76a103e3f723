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

"""The command that fits the ensemble of brakes to measured squeal."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import asdict
import datetime
import json
from pathlib import Path
from typing import Any

from squeal_core.calibration.applications import match_events, MatchedEvents, Observation
from squeal_core.calibration.calibrate import calibrate as run_calibration
from squeal_core.calibration.calibrate import Calibration
from squeal_core.calibration.calibration_file import write_calibration
from squeal_core.calibration.calibration_report import parameter_rows, remarks, report_lines
from squeal_core.calibration.evaluation import evaluate, Evaluation, evaluation_lines, of_one
from squeal_core.calibration.hearing_model import HearingModel
from squeal_core.calibration.importance_sampling import SamplingRound
from squeal_core.common.checks import check_number
from squeal_core.common.errors import SquealError
from squeal_core.common.version import __version__
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.results.event_places import event_places
from squeal_core.monitor.risk_warnings import NONE
from squeal_core.monitor.settings import ensemble_prior, MonitorSettings
from squeal_core.monitor.vehicle_risk import risk_settings
from squeal_core.risk.emulator_file import named_emulator
from squeal_core.risk.growth_emulator import GrowthEmulator
from squeal_core.surrogate.table_file import model_hash
from squeal_ros.cli.arguments import check_output, check_workers
from squeal_ros.cli.calibrate_recordings import GivenRecordings, ListenedApplications
from squeal_ros.cli.console import plain, report_progress, warn
from squeal_ros.cli.heard_events import heard_events

_MANY_TICKS = 20_000  # from which on processes are worth their start
_SUSPICIOUS = 0.2  # fraction of events outside of all applications
_LEAST_HELD_OUT = 10
_LEAST_TO_SPLIT = 20  # events, that as many as the likelihood wants are left to fit
_HEARING = ('detection', 'false_alarm', 'label_error', 'frequency_tolerance')


def calibrate(options: argparse.Namespace) -> int:
    """Read, match, fit, score, write."""
    hearing = HearingModel(**{name: getattr(options, name) for name in _HEARING})
    given = GivenRecordings.of(options)
    settings = given.task.settings
    _check(options, given)
    model = BrakeModel.load(settings.model)
    emulator = _emulator(model, options, settings)
    places = event_places(given.brakes, settings.axles)
    heard = heard_events(options, places)
    recorded = given.listened(options, heard)
    matched = match_events(recorded.applications, heard.events, places, zero=recorded.zero)
    if len(matched.unmatched) > _SUSPICIOUS * len(heard.events):
        warn(f'{len(matched.unmatched)} of {len(heard.events)} events are in no brake '
             f'application, the first at {matched.unmatched[0].time:g} s; check the clocks '
             '(--offset, --from-start) and the brakes')
    limits = risk_settings(settings)
    train, test = _split(matched.observations, options.held_out)

    def said(done: SamplingRound) -> None:
        report_progress(f'{done.draws} draws, {done.power:.0%} of the likelihood, effective '
                        f'sample size {done.effective_size:.0f}')

    result = run_calibration(
        model, emulator, recorded.applications, train, prior=ensemble_prior(settings),
        hearing=hearing, settings=limits, seed=options.seed, progress=said,
        workers=options.workers if options.workers > 1 and recorded.ticks > _MANY_TICKS else 0)
    evaluation = evaluate(result, model, emulator, recorded.applications, train, test,
                          hearing, limits) if test else None
    about = {'model_name': Path(settings.model).name,
             **_about(options, given, recorded, matched, result, evaluation, hearing)}
    write_calibration(result.ensemble(_in_words(result, about)), model, options.output, about,
                      overwrite=options.force)
    _print(options, result, evaluation, {**about, 'model': model_hash(model)},
           given.of_all_brakes(options.brakes))
    return 1 if _distrust(result, evaluation) else 0


def _check(options: argparse.Namespace, given: GivenRecordings) -> None:
    """Refuse before the work options with which it would fail afterwards."""
    check_output('--output', options.output, ('.yaml', '.yml'), force=options.force,
                 inputs=(*(one.path for one in given.batch), options.events or options.sound,
                         *filter(None, (options.config, options.emulator, options.signals))))
    check_workers(options.workers)
    if not 0.0 <= options.held_out <= 0.5:
        raise SquealError(f'--held-out: is {options.held_out:g}; give 0 to 0.5')
    for name, value in (('--offset', options.offset), ('--from', options.from_),
                        ('--to', options.to), ('--minimum-level', options.minimum_level)):
        if value is not None:
            check_number(name, value)
    if options.seed < 0:
        raise SquealError(f'--seed: is {options.seed}; give 0 or more')
    if None not in (options.from_, options.to) and not options.from_ < options.to:
        raise SquealError(f'--from, --to: are {options.from_:g} and {options.to:g} s; give two '
                          'times that rise')


def _emulator(model: BrakeModel, options: argparse.Namespace,
              settings: MonitorSettings) -> GrowthEmulator:
    named = '' if settings.growth_emulator == NONE else settings.growth_emulator
    emulator = named_emulator(options.emulator or named, model)
    if emulator is None:
        raise SquealError(f'{settings.model}: has no growth emulator; build one with `squeal '
                          f'tabulate {settings.model} --growth-only`, or give --emulator')
    return emulator


def _split(observations: Sequence[Observation], fraction: float
           ) -> tuple[list[Observation], list[Observation]]:
    """
    Return the observations to fit, and those to score.

    Every so many of one brake are scored, of those with squeal and of the silent ones alike; none
    where there are too few events.
    """
    if not fraction or sum(one.heard for one in observations) < _LEAST_TO_SPLIT:
        return list(observations), []
    step, alone = round(1.0 / fraction), of_one(observations)
    held = {id(one) for heard in (True, False)
            for one in [one for one in alone if one.heard == heard][step - 1::step]}
    return ([one for one in observations if id(one) not in held],
            [one for one in alone if id(one) in held])


def _held_out(fraction: float, events: int, evaluation: Evaluation | None) -> list[str]:
    """Return the remark on scores that are missing or of too few applications."""
    if evaluation is not None:
        return ['too few held out to judge'] * (evaluation.count < _LEAST_HELD_OUT)
    few = f' (too few events to hold some out, fewer than {_LEAST_TO_SPLIT})' * (
        fraction > 0.0 and events < _LEAST_TO_SPLIT)
    return [f'no scores{few}: too few held out to judge']


def _about(options: argparse.Namespace, given: GivenRecordings, recorded: ListenedApplications,
           matched: MatchedEvents, result: Calibration, evaluation: Evaluation | None,
           hearing: HearingModel) -> dict[str, Any]:
    """Return provenance, prior against posterior and scores, as the file has them."""
    return {
        'software': f'squeal_ros {__version__}', 'date': datetime.date.today().isoformat(),
        'recordings': sorted(recorded.zero),
        'events_file': Path(options.events or options.sound).name,
        'listened_to': given.listened_brakes(options.brakes),
        'observations': {
            'with_squeal': matched.heard, 'fitted_with_squeal': result.heard,
            'fitted_silent': result.silent,
            'held_out': evaluation.count if evaluation else 0,
            'incomplete': matched.incomplete, 'events_unmatched': len(matched.unmatched)},
        'hearing': asdict(hearing),
        'sampling': {'rounds': len(result.sample.rounds),
                     'draws': result.sample.rounds[-1].draws,
                     'effective_size': round(result.sample.effective_size, 1)},
        'parameters': {row.name: dict(zip(row._fields[1:], row[1:], strict=True))
                       for row in parameter_rows(result)},
        'remarks': [*remarks(result), *given.of_all_brakes(options.brakes),
                    *_held_out(options.held_out, matched.heard, evaluation)],
        'scores': {} if evaluation is None else {
            **{name.replace(' ', '_'): asdict(one) for name, one in evaluation.scores.items()},
            'calibration_curve': [list(one) for one in evaluation.curve],
            'frequency_error': evaluation.frequency_error}}


def _in_words(result: Calibration, about: Mapping[str, Any]) -> str:
    near = f', counted {result.likelihood_power:.0%}' if result.likelihood_power < 1.0 else ''
    return (f'calibrated with {result.heard} squealing and {result.silent} silent brake '
            f'applications on {about["date"]}{near}')


def _distrust(result: Calibration, evaluation: Evaluation | None) -> str:
    """Return the reason not to trust the calibration, as far as known; '' for none."""
    if not result.heard:
        return 'no event was fitted, so the ensemble is the prior and not calibrated'
    if result.likelihood_power < result.power:
        return 'too small a sample'
    if evaluation is None or evaluation.count < _LEAST_HELD_OUT:
        return ''
    scores = evaluation.scores
    worse = scores['calibrated'].brier > scores['base rate'].brier
    return 'no better than the base rate' if worse else ''


def _print(options: argparse.Namespace, result: Calibration, evaluation: Evaluation | None,
           about: Mapping[str, Any], of_all_brakes: Sequence[str]) -> None:
    why = _distrust(result, evaluation)
    if options.json:
        print(json.dumps(plain({
            **about, 'likelihood_power': result.likelihood_power, 'not_trusted': why,
            'output': options.output,
            'not_computed': evaluation.without if evaluation else ''})))
        return
    seen = about['observations']
    print(f'model: {about["model_name"]}, hash {about["model"][:12]}')
    print(f'fitted: {result.heard} of {seen["with_squeal"]} events (applications with squeal), '
          f'{result.silent} silent applications; left out: {seen["incomplete"]} hardly known, '
          f'{seen["events_unmatched"]} events in none')
    print('\n'.join([*report_lines(result), *of_all_brakes,
                     *(evaluation_lines(evaluation) if evaluation else []),
                     *_held_out(options.held_out, seen['with_squeal'], evaluation)]))
    if why:
        print(f'not to be trusted: {why}')
    print(f'written: {options.output}')
