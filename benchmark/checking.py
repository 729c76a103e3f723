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
