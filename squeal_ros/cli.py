"""The `squeal` command: reads arguments, calls the library, prints; computes nothing itself."""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse
from collections.abc import Callable, Sequence
import signal
import sys

from squeal_core.errors import SquealError
from squeal_ros import commands

GOOD, BAD_ANSWER, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; 0 good, 1 the answer is bad, 2 the input is bad."""
    options = parser().parse_args(arguments)
    # a command that is told to end ends as by Ctrl-C: processes stopped, half-written files gone
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    run: Callable[[argparse.Namespace], int] = options.run
    try:
        return run(options)
    except (SquealError, ImportError) as error:
        print(f'squeal: {" ".join(str(error).split())}', file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print('squeal: interrupted', file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # as in `squeal modes ... | head`
        sys.stderr.close()
        return GOOD


def parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command."""
    top = argparse.ArgumentParser(
        prog='squeal', description='Squeal stability of disc brakes: models, points, drives.')
    sub = top.add_subparsers(required=True, metavar='COMMAND')
    _build(sub.add_parser('build', help='a brake description -> a modal brake model'))
    _info(sub.add_parser('info', help='what a model file holds'))
    _modes(sub.add_parser('modes', help='complex modes at an operating point'))
    _settings(sub.add_parser('settings', help='print monitor settings for given brakes'))
    _replay(sub.add_parser('replay', help='the monitor over a recorded bag'))
    _drive(sub.add_parser('drive', help='play a drive cycle as brake signals on ROS topics'))
    _demo(sub.add_parser('demo', help='node, player and replay of a drive, end to end'))
    return top


def _build(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.build)
    p.add_argument('brake', metavar='BRAKE.yaml', help='brake description, or a shipped name')
    p.add_argument('-o', '--output', required=True, metavar='MODEL.npz')
    p.add_argument('--follower', action='store_true',
                   help='keep the in-plane follower force, which K09 leaves out')


def _info(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.info)
    _model(p)
    p.add_argument('--json', action='store_true')


def _modes(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.modes)
    _model(p)
    p.add_argument('--rotor-speed', type=float, required=True, metavar='RAD/S')
    p.add_argument('--friction', type=float, metavar='MU', help="default: the friction law's")
    slope = p.add_mutually_exclusive_group()
    slope.add_argument('--friction-slope', type=float, metavar='S/M',
                       help='d mu / d v (default 0 with --friction)')
    slope.add_argument('--friction-law', action='store_true',
                       help="the law's slope, scaled to --friction where that is given")
    load = p.add_mutually_exclusive_group()
    load.add_argument('--preload', type=float, metavar='N', help='of one pad (default 2000)')
    load.add_argument('--pressure', type=float, metavar='PA')
    p.add_argument('--contact-stiffness', type=float, metavar='N/M^3', help='default: nominal')
    p.add_argument('--all', action='store_true', help='list stable modes too')
    p.add_argument('--json', action='store_true')


def _settings(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.settings)
    p.add_argument('brakes', nargs='*', metavar='BRAKE', help="names (default: a car's four)")


def _replay(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.replay)
    p.add_argument('bag', metavar='BAG', help='rosbag2 folder, .mcap or .db3 file')
    p.add_argument('-o', '--output', required=True, metavar='OUT.mcap',
                   help='bag of outputs; a table goes beside it as OUT.csv')
    p.add_argument('--config', metavar='MONITOR.yaml', help='default: the shipped settings')
    p.add_argument('--model', metavar='MODEL', help="default: the settings' model")
    p.add_argument('--rate', type=float, metavar='HZ', help="default: the settings' rate")
    p.add_argument('--namespace', default='/', help='of the relative topics in the bag')
    p.add_argument('--json', action='store_true')


def _drive(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.drive)
    _cycle(p)
    p.add_argument('--speed-up', type=float, default=1.0, metavar='X', help='default 1')
    p.add_argument('--wall-time', action='store_true',
                   help='stamp with the system clock, publish no /clock (speed-up 1)')
    p.add_argument('--record', metavar='BAG', help='record the published signals')
    p.add_argument('--namespace', default='')


def _demo(p: argparse.ArgumentParser) -> None:
    p.set_defaults(run=commands.demo)
    _cycle(p)
    p.add_argument('--speed-up', type=float, default=8.0, metavar='X', help='default 8')
    p.add_argument('--rate', type=float, default=1.0, metavar='HZ',
                   help='assessments a second of the drive (default 1)')
    p.add_argument('--config', metavar='MONITOR.yaml', help='default: the shipped settings')
    p.add_argument('--output', default='demo_output', metavar='FOLDER')


def _model(p: argparse.ArgumentParser) -> None:
    p.add_argument('model', metavar='MODEL', help='path of a model file, or a shipped name')


def _cycle(p: argparse.ArgumentParser) -> None:
    p.add_argument('cycle', nargs='?', default='us06', metavar='CYCLE',
                   help='CSV of time_s,speed_m_s, or a shipped name (default us06)')
    p.add_argument('--vehicle', default='midsize', metavar='VEHICLE.yaml')
    p.add_argument('--model', default='kang2009', metavar='MODEL',
                   help='whose friction table the signals follow')
    p.add_argument('--duration', type=float, metavar='S', help='only the first seconds')


if __name__ == '__main__':
    sys.exit(main())
