"""Jobs on any executor: this process, processes, or Dask's workers on many machines."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, as_completed
from typing import Any, TypeVar

Result = TypeVar("Result")


def completed(
    executor: Executor | None, function: Callable[..., Result], jobs: Sequence[tuple[Any, ...]]
) -> Iterator[tuple[int, Result]]:
    """The number of each job and its result, in the order in which they are done.

        for number, result in completed(executor, function, [(1, 2), (3, 4)]):

    Where the caller stops, or a job fails, what has not begun is cancelled.

    Args:
        executor: of any kind; None: this process, one after the other. All that is sent to another
            process, and comes back from it, is pickled.
        function: what is called, of a module.
        jobs: its arguments, a tuple a job.
    """
    if executor is None:
        for number, job in enumerate(jobs):
            yield number, function(*job)
        return
    futures: dict[Future[Result], int] = {
        executor.submit(function, *job): number for number, job in enumerate(jobs)
    }
    try:
        for future in as_completed(list(futures)):
            number = futures.pop(future)  # so that nobody keeps the result but the caller
            yield number, future.result()
    finally:
        for future in futures:
            future.cancel()
