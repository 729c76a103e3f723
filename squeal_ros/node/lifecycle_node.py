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

"""The node `squeal_monitor`: the life cycle, and the work of a tick; no arithmetic."""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy
from squeal_ros import interrupts  # noqa: I100

import sys  # noqa: I100
import time
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.signals import SignalHandlerOptions
from squeal_core.common.errors import ConfigurationError, in_one_line, SquealError
from squeal_core.monitor.settings import MonitorSettings, NODE_NAME, pressure_references
from squeal_ros.node.arguments import check_arguments
from squeal_ros.node.configured_monitor import ConfiguredMonitor
from squeal_ros.node.executor import guard_services, report_exceptions, ResilientExecutor
from squeal_ros.node.node_statistics import Health, LostTicks
from squeal_ros.node.parameters import NodeParameters
from squeal_ros.node.tick_grid import Tick
from squeal_ros.node.ticker import Ticker
from squeal_ros.node.transitions import refuse_in_words

SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE
_LONGEST_WAIT = 0.1  # s, of an executor that nothing wakes, until it looks for a signal


class SquealMonitor(LifecycleNode):  # type: ignore[misc]
    """
    Managed node: configure loads the model, activate publishes.

    Parameters
    ----------
    alone : bool
        Whether its executor serves nothing else; the node then keeps its thread from tick to tick.
    **node_arguments
        Of rclpy's node.

    Raises
    ------
    SquealError
        From the constructor for bad parameters, and from `bring_up` for a bad model.

    """

    def __init__(self, *, alone: bool = False, **node_arguments: Any) -> None:
        super().__init__(NODE_NAME, automatically_declare_parameters_from_overrides=True,
                         **node_arguments)
        self._configured: ConfiguredMonitor | None = None
        self._configure_error: Exception | None = None
        self._starting = False
        self._last_unknown: int | None = None  # steady time
        self.health, self._lost_ticks = Health(), LostTicks()
        refuse_in_words(self)
        guard_services(self, self.report)
        self._parameters_of_ours = NodeParameters(
            self, lambda: self._configured is not None, self._update_settings)
        self._ticker = Ticker(self, *(report_exceptions(call, self.report) for call in (
            self._gather, self._tick, self._clock_stopped)), alone=alone)

    def declare_parameters(self, namespace: str, parameters: Any, *rest: Any,
                           **options: Any) -> Any:
        """Refuse, by name, a value that came without a type: `[]` in a file, which ROS has."""
        for name, *value in parameters:
            if value and value[0] is None:
                raise ConfigurationError(name, 'is an empty list, or has no value',
                                         'give it a value, or leave the key out')
        return super().declare_parameters(namespace, parameters, *rest, **options)

    @property
    def settings(self) -> MonitorSettings:
        """Return the settings of the present parameters."""
        return self._parameters_of_ours.settings

    def report(self, error: Exception) -> None:
        """Log and count an exception at one moment; the node goes on."""
        if not self.context.ok():  # it ended amid it: nothing can be published any more
            return
        self.health.errors += 1
        self.get_logger().error(f'{type(error).__name__}: {in_one_line(error)}',
                                throttle_duration_sec=10.0)

    def bring_up(self) -> None:
        """Configure and activate, if the parameter `autostart` says so."""
        if not self.settings.autostart:
            return
        self._starting = True
        configured = self.trigger_configure()
        self._starting = False
        if configured != SUCCESS:
            raise self._configure_error or SquealError('configuration failed; see the log')
        self.trigger_activate()

    def shut_down(self) -> None:
        """Go to the final state from any other; an active node first publishes its last state."""
        if self._state_machine.current_state[1] != 'finalized':
            self.trigger_shutdown()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load model and tables and create the topics."""
        try:
            self._configured = ConfiguredMonitor(
                self, self.settings, self.health, self.report)
        except Exception as error:  # rclpy would go to its error state without a word
            self._configure_error = error
            if not self._starting:  # while starting, whoever starts it says so
                kind = '' if isinstance(error, SquealError) else f'{type(error).__name__}: '
                self.get_logger().error(f'cannot configure: {kind}{error}')
            return FAILURE
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start assessments, without any earlier samples."""
        try:
            assert self._configured is not None
            self._configured.begin()
            self._start_ticker()
        except Exception as error:
            self.report(error)
            self._ticker.stop()
            return FAILURE
        self.get_logger().info(f'watching {", ".join(self._configured.monitor.brakes)} at '
                               f'{self.settings.rate:g} Hz; {pressure_references(self.settings)}')
        monitor = self._configured.monitor
        for note in (monitor.cross_checks.summary, *monitor.evaluator.notes):
            self.get_logger().info(note)
        missing = self._configured.outputs.why_no_state
        if missing:
            self.get_logger().info(f'~/<brake>/state is not published: {missing}', once=True)
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End alarms, publish that nothing is known, and stop."""
        self._leave_active()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Release model and topics."""
        self._release()
        return super().on_cleanup(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Release model and topics from any state; end alarms first."""
        if state.label == 'active':
            self._leave_active()
        self._release()
        return super().on_shutdown(state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Release all: the node is unconfigured then, and can be configured again."""
        self.get_logger().error(f'error in state {state.label}; cleaned up')
        self._release()
        return SUCCESS

    def _start_ticker(self) -> None:
        self._ticker.start(self.settings.period, round(self.settings.clock_timeout * 1e9))

    def _update_settings(self, settings: MonitorSettings) -> None:
        """Apply changed parameters, of which none is fixed while configured."""
        if self._configured is None:
            return
        self._configured.update_settings(settings)
        self._ticker.retime(settings.period, round(settings.clock_timeout * 1e9))

    def _gather(self) -> None:
        if self._configured is not None:
            self._configured.inputs.take()

    def _tick(self, tick: Tick) -> None:
        if self._configured is None:
            return
        start = time.perf_counter_ns()
        self._last_unknown = None
        self.health.begin(tick, self.settings.period)
        self._log_lost_ticks(tick)
        try:
            self._configured.assess(tick)
        finally:
            self.health.end(time.perf_counter_ns() - start, self.settings.period)

    def _log_lost_ticks(self, tick: Tick) -> None:
        lost = self.health.ticks_lost
        if self._lost_ticks.due(lost, time.monotonic_ns()):
            slower = ', or play the recording more slowly' if tick.simulated else ''
            self.get_logger().warning(
                f'ticks lost so far: {lost}; this processor does not keep up with rate '
                f'{self.settings.rate:g} Hz: lower `rate`, run less beside the node{slower}')

    def _clock_stopped(self, reason: str) -> None:
        """Publish at the rate of diagnostics that nothing is known while the clock stands."""
        steady = time.monotonic_ns()
        if self._last_unknown is None:
            self.health.clock_stops += 1
            self.get_logger().warning(reason)
        elif steady - self._last_unknown < 1e9 / self.settings.diagnostics_rate:
            return
        self._last_unknown = steady
        if self._configured is not None:
            self._configured.say_unknown(reason)

    def _leave_active(self) -> None:
        """Stop ticking; publish last, for late subscribers, that nothing is known."""
        self._ticker.stop()
        if self._configured is not None:
            say_unknown = report_exceptions(self._configured.say_unknown, self.report)
            say_unknown('the monitor is not active')

    def _release(self) -> None:
        self._ticker.stop()
        configured, self._configured = self._configured, None
        if configured is not None:
            report_exceptions(configured.destroy, self.report)()


def main(arguments: list[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM; 2 for a configuration that cannot be used."""
    signals = interrupts.EndAtOnce(0, always=True)
    context, started = Context(), False
    try:
        check_arguments(sys.argv[1:] if arguments is None else arguments)
        rclpy.init(args=arguments, context=context,
                   signal_handler_options=SignalHandlerOptions.NO)
        # rclpy's own handlers end the context, and what is published after that goes nowhere
        started = True
        signals.only_note()
        _serve(context, signals)
    except Exception as error:
        if started and not isinstance(error, SquealError):
            raise
        return _refuse(error)
    finally:
        context.try_shutdown()
    return 0


def _serve(context: Context, signals: interrupts.EndAtOnce) -> None:
    """Bring the node up and serve it until a signal comes; its last messages then get out."""
    node = SquealMonitor(alone=True, context=context)
    executor = ResilientExecutor(context=context, report=node.report)
    executor.add_node(node)
    try:
        node.bring_up()
        while not signals.came:
            executor.spin_once(_LONGEST_WAIT)
    finally:
        node.shut_down()
        executor.shutdown()  # its destructor reports an error where others ran before it


def _refuse(error: Exception) -> int:
    text = str(error)
    if type(error).__name__ == 'UnknownROSArgsError':
        text = f'--ros-args: {text} are no arguments of ROS; see squeal_monitor --help'
    print(f'{NODE_NAME}: {in_one_line(text)}', file=sys.stderr)
    return 2
