"""What every node here is: parameters, a chain, and topics, services and diagnostics around it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.service import Service
from rclpy.task import Future as RosFuture
from std_srvs.srv import SetBool, Trigger

from dead_reckoning.configuration import COMMON
from dead_reckoning.core.chain import FAULT, NOTICE, Chain, Output
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.errors import SettingsError, WireError
from dead_reckoning.core.parameters import Settings
from dead_reckoning.core.stages import ODOMETRY, ODOMETRY_MESSAGE
from dead_reckoning.nodes import parameters
from dead_reckoning.nodes.diagnostics import Diagnostics, Finding
from dead_reckoning.nodes.services import DeferredServices
from dead_reckoning.nodes.topics import decoder, message_class, publisher_qos, subscription_qos
from dead_reckoning.nodes.transforms import transform_sender
from dead_reckoning.nodes.watch import Input, TopicWatch
from dead_reckoning.topics import topics

SERVICE_PERIOD = 0.05
DIAGNOSTICS_PERIOD = 1.0
STEADY = Clock(clock_type=ClockType.STEADY_TIME)
"""What timers go by that have nothing to do with samples: it runs on when /clock stands."""


class ChainNode(Node):
    """A node around a chain: bytes in, samples through the chain, bytes out.

    Subclasses build their estimators from `configuration`, then call `connect` and `offer`.
    """

    def __init__(self, name: str, parts: Iterable[type[Settings]]) -> None:
        """Raise `SettingsError` for a parameter that is unknown or not allowed."""
        self._deferred: Collection[Service] = ()
        try:
            super().__init__(name)
        except ParameterException as error:  # a value that one of ROS's own keys can't have
            raise SettingsError(str(error)) from error
        self.configuration = parameters.declare(self, (*parts, *COMMON))
        self.common = self.configuration[CommonSettings]
        self.frames = self.configuration[FrameSettings]
        self._topics = topics(self.frames)
        self.finished: RosFuture = RosFuture()
        """Done once the node has done what it was asked for and wants to end."""
        self._chain = Chain([])
        self._writers: dict[str, Callable[[Any], None]] = {}
        self._demand: dict[str, int] = {}
        self._demanded = False
        self._figures: list[Callable[[], Mapping[str, object]]] = []
        self._closings: list[Callable[[], None]] = []
        self._topic_watch = TopicWatch(self, self.common.input_timeout)
        self._watches: list[Callable[[], Iterable[Finding]]] = [self._topic_watch.findings]
        self.diagnostics = Diagnostics(
            self, self._all_figures, self._all_findings, self._topic_watch.awaited
        )
        deferred = DeferredServices(self, self.common.service_timeout, self._count_usable)
        self._deferred = self._services_offered = deferred
        self.create_timer(SERVICE_PERIOD, deferred.poll, clock=STEADY)
        self.create_timer(DIAGNOSTICS_PERIOD, self.diagnostics.publish, clock=STEADY)

    @property
    def services(self) -> Iterator[Service]:
        """Yield the services that the executor answers: all but those that are deferred."""
        return (service for service in super().services if service not in self._deferred)

    def connect(
        self,
        chain: Chain,
        *,
        inputs: Iterable[str],
        outputs: Iterable[str],
        on_demand: Collection[str] = (),
        optional: Collection[str] = (),
    ) -> None:
        """Subscribe the inputs of a chain and publish its outputs, by topic name.

        Outputs named in ``on_demand`` are written only while someone subscribes; inputs named in
        ``optional`` need not come.
        """
        self._chain = chain
        for name in outputs:
            topic = self._topics[name]
            matched = partial(self._match, name) if name in on_demand else None
            publisher = self.create_publisher(
                message_class(topic),
                name,
                publisher_qos(topic.latched),
                # `_topic_watch` says more than rclpy's own callbacks.
                event_callbacks=PublisherEventCallbacks(
                    matched=matched, use_default_callbacks=False
                ),
                qos_overriding_options=QoSOverridingOptions.with_default_policies(),
            )
            self._topic_watch.add_output(name)
            self._writers[name] = partial(_write, publisher, topic.encode)
            if matched is not None:
                self._demand[name] = 0
                self._writers[name] = partial(self._write_on_demand, name, self._writers[name])
            elif name == ODOMETRY:
                self._writers[ODOMETRY_MESSAGE] = publisher.publish
        if self.frames.publish_tf and ODOMETRY in self._writers:
            self._writers[ODOMETRY] = _both(
                self._writers[ODOMETRY], transform_sender(self, self.frames)
            )
        for name in inputs:
            topic = self._topics[name]
            watched = self._topic_watch.add_input(name, topic.source, name not in optional)
            self.create_subscription(
                message_class(topic),
                name,
                partial(self._receive, watched, decoder(topic)),
                subscription_qos(),
                event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
                raw=True,
                qos_overriding_options=QoSOverridingOptions.with_default_policies(),
            )

    def offer(self, name: str, begin: Callable[[], Future[str] | str]) -> None:
        """Offer the Trigger service ``~/name``; see `DeferredServices.add`."""
        self._services_offered.add(name, Trigger, lambda _: self._settled(begin))

    def offer_switch(self, name: str, begin: Callable[[bool], Future[str] | str]) -> None:
        """Offer the SetBool service ``~/name``; ``begin`` takes what it is set to."""
        self._services_offered.add(
            name, SetBool, lambda request: self._settled(begin, request.data)
        )

    def follow(self, settings: Settings, apply: Callable[[Any], None]) -> None:
        """Hand changed settings to ``apply``; see `parameters.follow_changes`."""
        parameters.follow_changes(self, settings, partial(self._settled, apply))

    def show(self, figures: Callable[[], Mapping[str, object]]) -> None:
        """Add figures to what /diagnostics shows."""
        self._figures.append(figures)

    def watch(self, findings: Callable[[], Iterable[Finding]]) -> None:
        """Let /diagnostics and the log say what ``findings`` returns as long as it lasts."""
        self._watches.append(findings)

    def at_end(self, close: Callable[[], None]) -> None:
        """Call ``close`` when the node ends."""
        self._closings.append(close)

    def destroy_node(self) -> None:
        """Close what was opened, then destroy the node."""
        for close in self._closings:
            close()
        super().destroy_node()

    def finish(self) -> None:
        """Ask to end: what this node was started for is done."""
        self.finished.set_result(None)

    def count_subscribers_of(self, name: str) -> int:
        """Return how many subscribers a topic has, by its name in the design."""
        return self.count_subscribers(self.resolve_topic_name(name))

    def count_publishers_of(self, name: str) -> int:
        """Return how many publishers a topic has, by its name in the design."""
        return self.count_publishers(self.resolve_topic_name(name))

    def feed(self, name: str, sample: Any) -> None:
        """Take a sample of this node's own source: publish it, and run it through the chain."""
        self.diagnostics.samples += 1
        self.put_out([(name, sample)])
        self.push(name, sample)

    def push(self, name: str, value: Any) -> None:
        """Put something into the chain and publish what comes out of it; nothing after the end."""
        if not self.finished.done():
            self.put_out(self._chain.push(name, value))

    def put_out(self, flow: Iterable[Output]) -> None:
        """Publish what comes out of the chain, and say what went wrong."""
        for name, value in flow:
            write = self._writers.get(name)
            if write is not None:
                write(value)
            elif name == FAULT:
                self.diagnostics.fault(value)
            elif name == NOTICE:
                self.get_logger().info(value)

    def _receive(self, watched: Input, decode: Callable[[bytes], Any], data: bytes) -> None:
        watched.arrive()
        self.diagnostics.samples += 1
        if not (self._demanded or self.finished.done()):
            flow = self._chain.take(watched.name, data)
            if flow is not None:
                self.put_out(flow)
                return
        try:
            sample = decode(data)
        except WireError as error:
            self.diagnostics.fault(error)
            return
        self.push(watched.name, sample)

    def _settled(self, do: Callable[..., Any], *arguments: Any) -> Any:
        """Do what needs the estimators as they are now."""
        self._chain.settle()
        return do(*arguments)

    def _match(self, name: str, matched: Any) -> None:
        self._demand[name] = matched.current_count
        self._demanded = any(self._demand.values())

    def _write_on_demand(self, name: str, write: Callable[[Any], None], value: Any) -> None:
        if self._demand[name]:
            write(value)

    def _count_usable(self) -> int:
        return self.diagnostics.samples - self.diagnostics.dropped

    def _all_findings(self) -> Iterator[Finding]:
        return (finding for findings in self._watches for finding in findings())

    def _all_figures(self) -> Mapping[str, object]:
        self._chain.settle()
        return {key: value for figures in self._figures for key, value in figures().items()}


def _write(publisher: Publisher, encode: Callable[[Any], bytes], value: Any) -> None:
    publisher.publish(encode(value))


def _both(first: Callable[[Any], None], second: Callable[[Any], None]) -> Callable[[Any], None]:
    def write(value: Any) -> None:
        first(value)
        second(value)

    return write
