"""The node `squeal_monitor`: parameters, subscriptions, timer, publishers; no arithmetic."""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from array import array
from collections.abc import Callable, Sequence
from importlib import import_module
import signal
import sys
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
import rclpy
from rclpy.context import Context
from rclpy.exceptions import InvalidTopicNameException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import DurabilityPolicy, qos_profile_sensor_data, QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.timer import Timer

from squeal_core.brake_model import BrakeModel
from squeal_core.errors import ConfigurationError, SquealError
from squeal_core.monitor import Assessment, VehicleMonitor
from squeal_core.settings import (
    flatten, is_built_in, Key, MonitorSettings, NODE_NAME, read_settings, settings_keys)
from squeal_ros import messages
from squeal_ros.signals import Router

_LATE = 0.02  # of a period: a tick this late still counts as aligned


class RosMessages:
    """Message classes as rclpy provides them."""

    def type(self, name: str) -> Any:
        package, _, rest = name.partition('/')
        try:
            return getattr(import_module(f'{package}.msg'), rest.rpartition('/')[2])
        except (ImportError, AttributeError, ValueError):
            raise ConfigurationError('type', f'{name!r} is no message type known here',
                                     'install its package or mend the name') from None

    def floats(self, values: Sequence[float]) -> Any:
        return array('d', values)

    def byte(self, value: int) -> Any:
        return bytes([value])


class SquealMonitor(LifecycleNode):  # type: ignore[misc]
    """Managed node: configure loads the model, activate publishes.

    Raises
    ------
    SquealError
        From the constructor for bad parameters, and from `bring_up` for a bad model.
    """

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__(NODE_NAME, automatically_declare_parameters_from_overrides=True,
                         **node_arguments)
        self._guard_change_state()
        self.settings = self._declare_parameters()
        self._library = RosMessages()
        self._monitor: VehicleMonitor | None = None
        self._router: Router | None = None
        self._timer: Timer | None = None
        self._subscriptions_by_topic: dict[str, Any] = {}
        self._outputs: dict[tuple[str, str], Any] = {}
        self._diagnostics: Any = None
        self._configure_error: SquealError | None = None
        self._starting = False
        self._last_levels: list[int] = []
        self._last_diagnostics = 0
        self._last_tick: int | None = None
        self.ticks_done = 0
        self.ticks_lost = 0
        self.errors = 0

    def bring_up(self) -> None:
        """Configure and activate, if the parameter `autostart` says so."""
        if not self.settings.autostart:
            return
        self._starting = True
        configured = self.trigger_configure()
        self._starting = False
        if configured != TransitionCallbackReturn.SUCCESS:
            raise self._configure_error or SquealError('configuration failed; see the log')
        self.trigger_activate()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        try:
            self._configure()
        except SquealError as error:
            self._configure_error = error
            if not self._starting:  # while starting, whoever starts it says so
                self.get_logger().error(f'cannot configure: {error}')
            self._release()
            return TransitionCallbackReturn.FAILURE
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        assert self._monitor is not None
        self._monitor.reset()
        self._last_tick = None
        self._align_timer()
        self.get_logger().info(
            f'watching {", ".join(self._monitor.brakes)} at {self.settings.rate:g} Hz')
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._stop_timer()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._release()
        return super().on_cleanup(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._release()
        return super().on_shutdown(state)

    def _configure(self) -> None:
        model = BrakeModel.load(self.settings.model)
        self._router = Router.of(self.settings)
        self._monitor = VehicleMonitor(self.settings, model)
        for topic, type_name in self._router.types.items():
            self._subscribe(topic, type_name)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        for brake in self._monitor.brakes:
            for name, type_name in messages.TYPES.items():
                qos = latched if name == 'unstable_frequencies' else QoSProfile(depth=10)
                self._outputs[brake, name] = self.create_lifecycle_publisher(
                    self._library.type(type_name), f'~/{brake}/{name}', qos)
        self._diagnostics = self.create_lifecycle_publisher(
            self._library.type(messages.DIAGNOSTICS_TYPE), '/diagnostics', 10)

    def _subscribe(self, topic: str, type_name: str) -> None:
        def receive(message: Any) -> None:
            self._receive(topic, message)

        try:
            self._subscriptions_by_topic[topic] = self.create_subscription(
                self._library.type(type_name), topic, self._safely(receive),
                qos_profile_sensor_data)
        except InvalidTopicNameException as error:
            text = ' '.join(str(error).split())
            raise ConfigurationError('topic', f'{topic!r} ({text})', 'mend the name') from None

    def _receive(self, topic: str, message: Any) -> None:
        if self._router is None or self._monitor is None:
            return
        problems = len(self._router.problems)
        now = self.get_clock().now().nanoseconds
        for brake, name, sample in self._router.samples(topic, message, now):
            self._monitor.receive(brake, name, sample)
        if len(self._router.problems) > problems:  # said once, counted after
            self.get_logger().warning(f'cannot read {list(self._router.problems)[-1]}')

    def _align_timer(self, tries: int = 5) -> None:
        """Tick on multiples of the period: replayed ticks then fall on the same times.

        The first timer leads to a multiple, the second goes on from there; where the first comes
        late (a coarse simulated clock, a busy start) it is tried again.
        """
        self._stop_timer()
        period, tick = self.settings.period, self._safely(self._tick)

        def start() -> None:
            if tries and self.get_clock().now().nanoseconds % period > _LATE * period:
                self._align_timer(tries - 1)
                return
            self._stop_timer()
            self._timer = self.create_timer(period * 1e-9, tick)
            tick()

        wait = period - self.get_clock().now().nanoseconds % period
        self._timer = self.create_timer(wait * 1e-9, self._safely(start))

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self.destroy_timer(self._timer)
            self._timer = None

    def _tick(self) -> None:
        if self._monitor is None:
            return
        period, now = self.settings.period, self.get_clock().now().nanoseconds
        tick = now // period
        if self._last_tick is not None:
            if tick == self._last_tick:
                return
            if tick < self._last_tick:
                self._monitor.reset()
            self.ticks_lost += max(0, tick - self._last_tick - 1)
        self._last_tick = tick
        assessments = self._monitor.assess(tick * period)
        self.ticks_done += 1
        for assessment in assessments:
            for name, message in messages.brake_messages(self._library, assessment):
                self._outputs[assessment.brake, name].publish(message)
        self._publish_diagnostics(assessments)

    def _publish_diagnostics(self, assessments: tuple[Assessment, ...]) -> None:
        warning, time = self.settings.risk_warning, assessments[0].time
        levels = [messages.level(a, warning) for a in assessments]
        due = abs(time - self._last_diagnostics) >= 1e9 / self.settings.diagnostics_rate
        if not due and levels == self._last_levels:
            return
        self._last_levels, self._last_diagnostics = levels, time
        self._diagnostics.publish(messages.diagnostics(
            self._library, self.get_name(), assessments, warning, self._node_values()))

    def _node_values(self) -> dict[str, object]:
        assert self._router is not None
        return {'ticks_done': self.ticks_done, 'ticks_lost': self.ticks_lost,
                'errors': self.errors, 'unreadable_messages': self._router.problems.total()}

    def _safely(self, callback: Callable[..., None]) -> Callable[..., None]:
        """Keep an exception of one moment from ending `spin`: log, count, go on."""
        def guarded(*arguments: Any) -> None:
            try:
                callback(*arguments)
            except Exception as error:
                self.errors += 1
                self.get_logger().error(f'{type(error).__name__}: {error}',
                                        throttle_duration_sec=10.0)
        return guarded

    def _release(self) -> None:
        self._stop_timer()
        for subscription in self._subscriptions_by_topic.values():
            self.destroy_subscription(subscription)
        self._subscriptions_by_topic.clear()
        for publisher in (*self._outputs.values(), self._diagnostics):
            if publisher is not None:
                self.destroy_lifecycle_publisher(publisher)
        self._outputs.clear()
        self._diagnostics = self._monitor = self._router = None

    def _declare_parameters(self) -> MonitorSettings:
        """Declare every key with its description; parameters given but unknown are refused."""
        given = {name: parameter.value for name, parameter in self._parameters.items()
                 if not is_built_in(name)}
        settings = read_settings(flatten(given))
        for key in settings_keys(tuple(brake.name for brake in settings.brakes)):
            value = key.read(given.get(key.name, key.default))
            if key.name in given:
                self.undeclare_parameter(key.name)
            self.declare_parameter(key.name, list(value) if isinstance(value, tuple) else value,
                                   _descriptor(key), ignore_override=True)
        return settings

    def _guard_change_state(self) -> None:
        """Answer an invalid request with failure: unguarded it would end the node (rclpy#1209)."""
        change_state = self._service_change_state.callback

        def guarded(request: Any, response: Any) -> Any:
            try:
                return change_state(request, response)
            except Exception as error:
                self.get_logger().warning(f'refused a state change: {error}')
                response.success = False
                return response

        self._service_change_state.callback = guarded


def _descriptor(key: Key) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        description=f'{key.meaning} [{key.unit}]', read_only=True)
    if isinstance(key.default, float) and abs(key.minimum) < 1e300:
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=key.minimum, to_value=key.maximum)]
    return descriptor


def main(arguments: list[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM; 2 for a configuration that cannot be used."""
    context, started = Context(), False
    # rclpy's own handler ends the context; a KeyboardInterrupt beside it could strike anywhere
    signal.signal(signal.SIGINT, lambda *_: None)
    try:
        rclpy.init(args=arguments, context=context,
                   signal_handler_options=SignalHandlerOptions.ALL)
        started = True
        executor = SingleThreadedExecutor(context=context)
        node = SquealMonitor(context=context)
        executor.add_node(node)
        node.bring_up()
        executor.spin()
    except ExternalShutdownException:
        pass
    except SquealError as error:
        return _refuse(error)
    except Exception as error:
        if not started:
            return _refuse(error)
        if context.ok():
            raise
        # a signal ended the context under a call: rclpy then raises whatever that call raises
    finally:
        context.try_shutdown()
    return 0


def _refuse(error: Exception) -> int:
    print(f'{NODE_NAME}: {" ".join(str(error).split())}', file=sys.stderr)
    return 2


if __name__ == '__main__':
    sys.exit(main())
