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

"""Subscriptions of the node: any message type, any publisher; received messages and silence."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from operator import itemgetter
import time
from typing import Any, NamedTuple

from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.serialization import deserialize_message
from squeal_core.common.errors import ConfigurationError, did_you_mean
from squeal_ros.node.executor import DeferredCallbackGroup
from squeal_ros.node.message_types import RosMessages
from squeal_ros.node.node_statistics import Rate
from squeal_ros.node.silence import Silence

# policies of a topic's quality of service that settings may change
POLICIES = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY,
            QoSPolicyKind.DURABILITY)
_UNNAMED = '_UNKNOWN_'  # in the names of a node that was discovered only in part
_NO_NUMBER = 2**64 - 1  # RMW_MESSAGE_INFO_SEQUENCE_NUMBER_UNSUPPORTED
_LOOK_PERIOD = 1_000_000_000  # ns
_DEPTH = 20  # 2 kHz from one wake-up to the next; more than that only makes a busy node later


class _Moment(NamedTuple):
    """Time of taking messages [ns]: on the node's clock and the system's, and since last time."""

    now: int
    system: int
    passed: int

    def received(self, info: Mapping[str, Any]) -> int:
        """
        Return when a message came, on the node's clock.

        The middleware notes it on the system's, which may have been set since, or not at all.
        """
        noted: int = info['received_timestamp']
        return self.now - min(max(self.system - noted, 0), self.passed)


@dataclass
class _Topic:
    kind: Any
    subscription: Any = None
    received: int = 0
    dropped: int = 0
    undecodable: int = 0
    sequence: int | None = None
    alone: bool = False  # one publisher: only then do sequence numbers show gaps
    publishers: frozenset[bytes] = frozenset()
    names: tuple[str, ...] = ()  # of the publishers
    wrong: tuple[str, ...] = ()
    rate: Rate = field(default_factory=Rate)

    @property
    def type_name(self) -> str:
        return f'{self.kind.__module__.partition(".")[0]}/msg/{self.kind.__name__}'


class InputTopics:
    """
    One subscription a topic; messages go to `receive`.

    That is given the topic, the message, its time of receipt [ns] and the number that its
    publisher gave it (0: the middleware gives none).

    Messages wait in their queues for `take`: an executor that woke for each of them would cost
    more than all else. They are taken as bytes and decoded here: the middleware would throw away
    without a word what it cannot decode.

    Parameters
    ----------
    node : rclpy.node.Node
    library : RosMessages
    types : mapping
        Message type of each topic.
    aside : DeferredCallbackGroup
        For the subscriptions and all events; served once a second.
    receive : callable
    complain : callable
        Given a text, of which the caller says each once.

    Raises
    ------
    ConfigurationError
        For a type, a topic name or a quality of service that is none.

    """

    def __init__(self, node: Node, library: RosMessages, types: Mapping[str, str],
                 aside: DeferredCallbackGroup, receive: Callable[[str, Any, int, int], None],
                 complain: Callable[[str], None]) -> None:
        self._node, self._receive, self._complain = node, receive, complain
        self._aside = aside
        self._looked: int | None = None
        self._silence = Silence()
        self._taken = time.monotonic_ns()
        self._topics = {topic: _Topic(library.type(name)) for topic, name in types.items()}
        try:
            for topic, result in self._topics.items():
                result.subscription = self._subscribe(topic, result)
        except Exception:
            self.destroy()
            raise

    def destroy(self) -> None:
        """Unsubscribe from all topics."""
        for topic in self._topics.values():
            if topic.subscription is not None:
                self._node.destroy_subscription(topic.subscription)
                topic.subscription = None

    def begin(self) -> None:
        """Discard waiting messages, as if they had never come."""
        for topic in self._topics.values():
            for _ in _queue(topic):
                pass
            topic.sequence = None
        self._silence.begin()
        self._taken = time.monotonic_ns()

    def take(self) -> None:
        """Take all that has come since the last time, in the order in which it came."""
        self._aside.open = False
        moment = self._moment()
        self._taken = time.monotonic_ns()
        come = [(info['received_timestamp'], name, topic, data, info)
                for name, topic in self._topics.items() for data, info in _queue(topic)]
        for _, name, topic, data, info in sorted(come, key=itemgetter(0)):
            self._read(name, topic, data, info, moment.received(info))

    def _moment(self) -> _Moment:
        clock = self._node.get_clock()
        passed = 0 if clock.ros_time_is_active else time.monotonic_ns() - self._taken
        return _Moment(clock.now().nanoseconds, time.time_ns(), passed)

    def values(self, steady: int) -> dict[str, object]:
        """Return the figures of each topic: messages a second and since configured."""
        figures: dict[str, object] = {}
        for name, topic in self._topics.items():
            figures[f'{name} rate_hz'] = topic.rate.update(topic.received, steady)
            figures[f'{name} received'] = topic.received
            figures[f'{name} dropped'] = topic.dropped
        return figures

    @property
    def undecodable(self) -> int:
        """Return the number of messages that could not be decoded."""
        return sum(topic.undecodable for topic in self._topics.values())

    @property
    def dropped(self) -> int:
        """Return the number of lost messages, by the sequence numbers of their publishers."""
        return sum(topic.dropped for topic in self._topics.values())

    def publishers(self, topic: str) -> str:
        """Return, in words, how many publishers a topic has, and which."""
        names = self._topics[topic].names
        return f'{len(names)} publishers ({", ".join(names)})'

    def look_around(self, steady: int) -> tuple[str, ...]:
        """
        Return, in words, publishers whose messages cannot come: of another type.

        The graph is looked at once a second at most [ns of steady time]; then the executor may
        serve events, too, until messages are taken again.
        """
        if self._looked is None or steady - self._looked >= _LOOK_PERIOD:
            self._looked = steady
            self._aside.open = True
            self._look()
            self._log_silence(steady)
        return tuple(text for topic in self._topics.values() for text in topic.wrong)

    def _log_silence(self, steady: int) -> None:
        """Log inputs that bring nothing, with what is published under a similar name."""
        silent = self._silence.due({name: t.received for name, t in self._topics.items()}, steady)
        if not silent:
            return
        node = self._node
        own = dict(node.get_publisher_names_and_types_by_node(
            node.get_name(), node.get_namespace()))
        published = [name for name, _ in node.get_topic_names_and_types()
                     if name not in own and node.count_publishers(name)]
        words = []
        for name in silent:
            publishers = self._topics[name].names
            words.append(f'{name} (published by {", ".join(publishers)})' if publishers else
                         f'{name} (nobody publishes it)'
                         f'{did_you_mean(node.resolve_topic_name(name), published)}')
        node.get_logger().warning(f'no message came on {", ".join(words)}; check topics, '
                                  'namespace, ROS_DOMAIN_ID and quality of service')

    def _look(self) -> None:
        for name, topic in self._topics.items():
            publishers = self._node.get_publishers_info_by_topic(name)
            topic.alone = len(publishers) == 1
            result = frozenset(bytes(info.endpoint_gid) for info in publishers)
            if result != topic.publishers:  # each counts its messages from a number of its own
                topic.publishers, topic.sequence = result, None
            topic.names = tuple(sorted(map(_name, publishers)))
            topic.wrong = tuple(sorted(set(self._wrong(name, topic, publishers))))
            for text in topic.wrong:
                self._complain(text)

    def _wrong(self, name: str, topic: _Topic, publishers: list[Any]) -> Iterator[str]:
        own = [str(info.topic_type_hash)
               for info in self._node.get_subscriptions_info_by_topic(name)
               if info.node_name == self._node.get_name()
               and info.node_namespace == self._node.get_namespace()]
        for info in publishers:
            publisher = _name(info)
            if info.topic_type != topic.type_name:
                yield (f'{name}: {publisher} publishes {info.topic_type}, and '
                       f'{topic.type_name} is wanted')
            elif own and str(info.topic_type_hash) not in own:
                yield f'{name}: {publisher} publishes another version of {topic.type_name}'

    def _subscribe(self, topic: str, result: _Topic) -> Any:
        def receive(data: bytes, info: Mapping[str, Any]) -> None:
            self._read(topic, result, data, info, self._moment().received(info))

        qos = QoSProfile(depth=_DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT,
                         durability=DurabilityPolicy.VOLATILE)
        with naming(topic):
            return self._node.create_subscription(
                result.kind, topic, receive, qos, raw=True, callback_group=self._aside,
                qos_overriding_options=QoSOverridingOptions(POLICIES))

    def _read(self, topic: str, result: _Topic, data: bytes, info: Mapping[str, Any],
              received: int) -> None:
        result.received += 1
        sequence = info.get('publication_sequence_number') or 0
        if result.alone and sequence and result.sequence and sequence > result.sequence:
            result.dropped += sequence - result.sequence - 1
        result.sequence = sequence
        try:
            message = deserialize_message(data, result.kind)
        except Exception as error:
            result.undecodable += 1
            self._complain(f'{topic}: no {result.type_name} ({type(error).__name__})')
            return
        self._receive(topic, message, received, sequence if 0 < sequence < _NO_NUMBER else 0)


def _name(info: Any) -> str:
    publisher = f'{info.node_namespace.rstrip("/")}/{info.node_name}'
    return 'a publisher' if _UNNAMED in publisher else publisher


def _queue(topic: _Topic) -> Iterator[tuple[bytes, Mapping[str, Any]]]:
    """Yield the messages that wait, at most a queue of them: others go on coming."""
    subscription = topic.subscription
    with subscription.handle:
        for _ in range(max(subscription.qos_profile.depth, _DEPTH)):  # none if all are kept
            taken = subscription.handle.take_message(topic.kind, True)
            if taken is None:
                return
            yield taken


@contextmanager
def naming(topic: str) -> Iterator[None]:
    """Turn exceptions of rclpy over a topic into a ConfigurationError that names it."""
    try:
        yield
    except InvalidTopicNameException as error:
        text = ' '.join(str(error).split())
        raise ConfigurationError('topic', f'{topic!r} ({text})', 'correct the name') from None
    except ConfigurationError:
        raise
    except Exception as error:
        text = ' '.join(str(error).split())
        raise ConfigurationError(
            f'qos_overrides of {topic}', f'{type(error).__name__}: {text}',
            'give reliability, durability, history and depth as ROS names them') from None
