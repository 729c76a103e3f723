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

"""What the checks of accuracy share: their options, and how they say how far they are."""

import argparse
import sys


def check_options(description: str, points: int) -> argparse.ArgumentParser:
    """Return a parser of --points, --model, --seed and --json."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument('--points', type=int, default=points)
    parser.add_argument('--model', default='kang2009')
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--json', action='store_true')
    return parser


def said(text: str) -> None:
    """Show a line that the next one replaces, where someone looks on."""
    if sys.stderr.isatty():
        print(f'\r{text}', end='', file=sys.stderr, flush=True)
