"""Notice what does not come: silent inputs, endpoints that do not match, a clock that stands."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from itertools import product
from math import inf

from rclpy.node import Node
from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.topic_endpoint_info import TopicEndpointInfo

from dead_reckoning.core.errors import (
    ClockError,
    MismatchError,
    SeveralPublishersError,
    SilentInputError,
)
from dead_reckoning.nodes.diagnostics import Finding

NAMELESS = '_NODE_NAME_UNKNOWN_'
"""What rcl calls the node of an endpoint that it has discovered before the node."""


class Input:
    """One subscribed topic, and what came on it."""

    def __init__(self, name: str, topic: str, source: str, needed: bool) -> None:
        """``name`` as subscribed, ``topic`` in full; ``source``: who publishes it, in words.

        Nobody misses an input without a ``source``.
        """
        self.name = name
        self.topic = topic
        self.source = source
        self.needed = needed
        self.count = 0
        """Messages so far."""
        self._latest = inf
        self._gap = 0.0

    def arrive(self) -> None:
        """Count a message."""
        now = time.monotonic()
        self._gap, self._latest = now - self._latest, now
        self.count += 1

    def silence(self) -> float:
        """Return how long [s] no message has come: since the last, or before it if longer.

        So one message does not end a silence: a topic that is too slow would come and go.
        """
        return max(self._gap, time.monotonic() - self._latest)


class TopicWatch:
    """Look at the inputs and outputs of a node, once in a while, by the clock on the wall.

    An input that brought messages and then none for ``timeout`` [s] is a finding; so is one that
    is needed and never brought any while another does; endpoints of another type or an
    incompatible quality of service; and several publishers of one input.  A finding lasts as long
    as its cause.
    """

    def __init__(self, node: Node, timeout: float) -> None:
        self._node = node
        self._timeout = timeout
        self._inputs: list[Input] = []
        self._outputs: list[str] = []
        self._begun = 0.0

    def add_input(self, name: str, source: str, needed: bool) -> Input:
        """Watch a subscription by the name it was made with; return where to count."""
        watched = Input(name, self._node.resolve_topic_name(name), source, needed)
        self._inputs.append(watched)
        return watched

    def add_output(self, name: str) -> None:
        """Watch a publisher by the name it was made with."""
        self._outputs.append(name)

    def awaited(self) -> str:
        """Say which needed inputs have not brought anything yet, and why; empty for none."""
        return '; '.join(
            f'{each.topic}: {self._source_of(each)}'
            for each in self._inputs
            if each.needed and not each.count
        )

    def findings(self) -> Iterator[Finding]:
        """Yield what is wrong now."""
        yield from self._mismatches()
        yield from self._crowded()
        yield from self._silent()

    def _silent(self) -> Iterator[Finding]:
        now = time.monotonic()
        others = ' and '.join(each.topic for each in self._inputs if each.count)
        if not others:
            self._begun = now  # nothing has come yet, so nothing lacks beside it
        for each in self._inputs:
            if each.source and each.silence() > self._timeout:
                said = f'no message on {each.topic} for {each.silence():.0f} s'
                more = '; if it is that slow, raise common.input_timeout'
            elif each.needed and not each.count and now - self._begun > self._timeout:
                said, more = f'{others} came, but nothing on {each.topic} so far', ''
            else:
                continue
            yield each.topic, SilentInputError(f'{said}: {self._source_of(each)}{more}')

    def _source_of(self, each: Input) -> str:
        found = self._node.get_publishers_info_by_topic(each.name)
        if not found:
            return (
                f'it has no publisher: start {each.source}, or check namespace, remapping and '
                'ROS_DOMAIN_ID'
            )
        return (
            f'its publisher {_names(found)} is silent: a paused bag, an unplugged sensor, or see '
            'what it says on /diagnostics'
        )

    def _crowded(self) -> Iterator[Finding]:
        for each in self._inputs:
            found = self._node.get_publishers_info_by_topic(each.name)
            if len(found) > 1:
                error = SeveralPublishersError(
                    f'{each.topic} has {len(found)} publishers, {_names(found)}: their samples '
                    'mix; end all but one, or remap them'
                )
                yield each.topic, error

    def _mismatches(self) -> Iterator[Finding]:
        for name in (*(each.name for each in self._inputs), *self._outputs):
            publishers = self._node.get_publishers_info_by_topic(name)
            subscriptions = self._node.get_subscriptions_info_by_topic(name)
            topic = self._node.resolve_topic_name(name)
            for publisher, subscription in product(publishers, subscriptions):
                if self._is_ours(publisher) == self._is_ours(subscription):
                    continue
                if NAMELESS in (publisher.node_name, subscription.node_name):
                    continue
                why = _difference(publisher, subscription)
                if why:
                    ends = f'from {_names([publisher])} to {_names([subscription])}'
                    error = MismatchError(
                        f'{topic}: nothing passes {ends}: {why}; let both agree (of this node: '
                        f'qos_overrides.{topic})'
                    )
                    yield f'{topic} {ends}', error

    def _is_ours(self, end: TopicEndpointInfo) -> bool:
        node = self._node
        return (end.node_name, end.node_namespace) == (node.get_name(), node.get_namespace())


class ClockWatch:
    """Notice that a node goes by /clock, and that it stands, for whom nothing goes on then."""

    def __init__(self, node: Node, timeout: float) -> None:
        """``timeout`` [s] by the clock on the wall."""
        self._node = node
        self._timeout = timeout
        self._now_ns = -1
        self._since = 0.0

    def findings(self) -> Iterator[Finding]:
        """Yield what is wrong now; it must be asked again and again."""
        clock = self._node.get_clock()
        if not getattr(clock, 'ros_time_is_active', False):
            return
        now, now_ns = time.monotonic(), clock.now().nanoseconds
        if now_ns != self._now_ns:
            self._now_ns, self._since = now_ns, now
        standing = now - self._since
        if standing <= self._timeout:
            return
        if now_ns == 0:
            said = (
                'use_sim_time is true, and no /clock came: play the bag with --clock, start the '
                'simulator, or set use_sim_time to false'
            )
        else:
            said = (
                f'/clock has stood at {now_ns * 1e-9:.3f} s for {standing:.0f} s: let the bag or '
                'the simulator go on'
            )
        yield '/clock', ClockError(said)


def _names(ends: Sequence[TopicEndpointInfo]) -> str:
    return ', '.join(f'{end.node_namespace.rstrip("/")}/{end.node_name}' for end in ends)


def _difference(publisher: TopicEndpointInfo, subscription: TopicEndpointInfo) -> str:
    """Say why a publisher does not reach a subscription; empty where it does."""
    if publisher.topic_type != subscription.topic_type:
        return f'{publisher.topic_type} is published, {subscription.topic_type} subscribed'
    compatible, reason = qos_check_compatible(publisher.qos_profile, subscription.qos_profile)
    if compatible != QoSCompatibility.ERROR:
        return ''
    told = [part for part in reason.split(';') if part.startswith('ERROR: ')]
    return ', '.join(part.removeprefix('ERROR: ').lower() for part in told)
