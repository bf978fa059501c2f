"""Let a service ask an estimator for something that takes some samples to do."""

from __future__ import annotations

from concurrent.futures import Future

from dead_reckoning.core.errors import DeadReckoningError, SupersededError


class Work:
    """One task that ends some samples later, with a sentence for the user or with an error.

    The estimator that owns it ends it; whoever asked waits on the future.
    """

    def __init__(self) -> None:
        self._future: Future[str] | None = None

    def begin(self) -> Future[str]:
        """Start the task; one that still runs ends with `SupersededError`."""
        self.fail(SupersededError('the same was asked for again meanwhile: ask again'))
        self._future = Future()
        return self._future

    @property
    def running(self) -> bool:
        """Whether someone waits."""
        return self._future is not None

    def succeed(self, said: str) -> None:
        """End the task, if there is one, with a sentence for the user."""
        future, self._future = self._future, None
        if future is not None:
            future.set_result(said)

    def fail(self, error: DeadReckoningError) -> None:
        """End the task, if there is one, with the reason why it failed."""
        future, self._future = self._future, None
        if future is not None:
            future.set_exception(error)
