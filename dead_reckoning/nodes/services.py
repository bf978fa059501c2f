"""Services that answer when the work is done, without keeping anything else waiting."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from typing import Any

from rclpy.node import Node
from rclpy.service import Service

from dead_reckoning.core.errors import DeadReckoningError

Begin = Callable[[Any], Future[str] | str]
"""Start the work that a request asks for; return its future, or the answer."""


class DeferredServices:
    """Services whose reply is sent some samples after the request.

    Their types are those of std_srvs whose response says ``success`` and ``message``: Trigger and
    SetBool.

    rclpy answers a request when its callback returns, and neither of its executors lets a callback
    wait for samples without starving the subscriptions (the events executor takes no coroutine).
    So these services are kept from the executor: `poll`, called by a timer, takes the requests,
    starts the work, and replies to those whose work has ended.
    """

    def __init__(self, node: Node, timeout: float, usable: Callable[[], int]) -> None:
        """Wait ``timeout`` [s] by the clock on the wall for samples that can be used.

        ``usable`` returns how many there were so far.
        """
        self._node = node
        self._patience = _Patience(timeout, usable)
        self._works: dict[str, tuple[Service, list[Begin]]] = {}
        self._requests: list[_Request] = []

    def __contains__(self, service: Service) -> bool:
        return any(service is offered for offered, _ in self._works.values())

    def add(self, name: str, service_type: Any, begin: Begin) -> None:
        """Offer ``~/name``; ``begin`` takes the request and starts the work.

        Several works under one name, which then are of one type, are done one after the other, in
        the order they were added.
        """
        if name not in self._works:
            service = self._node.create_service(service_type, f'~/{name}', _never_called)
            self._works[name] = (service, [])
        service, works = self._works[name]
        assert service.srv_type is service_type, f'~/{name} has a type already'
        works.append(begin)

    def poll(self) -> None:
        """Take new requests, carry on with the works, reply to the requests that are done."""
        for service, works in self._works.values():
            with service.handle:
                request, header = service.handle.service_take_request(service.srv_type.Request)
            if request is not None:
                self._patience.renew()
                self._requests.append(_Request(service, request, header, iter(works)))
        lost = self._patience.is_lost()
        self._requests = [request for request in self._requests if not request.proceed(lost)]


class _Patience:
    """Whether usable samples have come within a time, on the wall's clock."""

    def __init__(self, timeout: float, usable: Callable[[], int]) -> None:
        self._timeout = timeout
        self._usable = usable
        self._seen = 0
        self.renew()

    def renew(self) -> None:
        self._deadline = time.monotonic() + self._timeout

    def is_lost(self) -> bool:
        if self._usable() != self._seen:
            self._seen = self._usable()
            self.renew()
        return time.monotonic() > self._deadline


class _Request:
    """One request on its way through the works of its service."""

    def __init__(
        self, service: Service, request: Any, header: Any, works: Iterator[Begin]
    ) -> None:
        self._service = service
        self._request = request
        self._header = header
        self._works = works
        self._said: list[str] = []
        self._current: Future[str] | None = None

    def proceed(self, samples_lack: bool) -> bool:
        """Go as far as is possible now; return whether the reply was sent."""
        try:
            while self._current is None or self._current.done():
                if self._current is not None:
                    self._said.append(self._current.result())
                    self._current = None
                begin = next(self._works, None)
                if begin is None:
                    return self._reply(True, '; '.join(self._said))
                answer = begin(self._request)
                if isinstance(answer, Future):
                    self._current = answer
                else:
                    self._said.append(answer)
        except DeadReckoningError as error:
            return self._reply(False, '; '.join([*self._said, str(error)]))
        if not samples_lack:
            return False
        return self._reply(
            False,
            'no samples to work with: is the topic published, does its quality of service match, '
            'or are they dropped? See /diagnostics; common.service_timeout says how long to wait',
        )

    def _reply(self, success: bool, message: str) -> bool:
        response = self._service.srv_type.Response(success=success, message=message)
        self._service.send_response(response, self._header)
        return True


def _never_called(request: Any, response: Any) -> Any:
    raise AssertionError('the executor must not see a deferred service')
