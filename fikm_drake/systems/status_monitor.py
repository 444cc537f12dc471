"""The block that says in one number how the controller does."""

from math import isfinite

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.checks import check_counts, check_positive
from fikm_drake.control.restart_state import RestartState
from fikm_drake.control.status import controller_status
from fikm_drake.control.steps import length


class StatusMonitor(LeafSystem):
    """One number for how the controller does, see `ControllerStatus`.

    .. pydrake_system::

        name: StatusMonitor
        input_ports:
        - task_error
        - valid
        - limited
        - oscillating
        - calmed
        - following
        - restart_search
        - blocked
        - sent_error
        output_ports:
        - status

    - **task_error** (m) [m].
    - **valid**, **limited**, **oscillating**, **calmed**, **following** (1 each): 0 or 1, from the
      blocks' ports of these names.
    - **restart_search** (1): of `RestartPlanner`; the port exists with `restart_search` only.
    - **blocked** (1): of `ClearanceFilter`; the port exists with `blocked` only.
    - **sent_error** (m) [m]: task error of what goes out, smoothed for a limit of jerk; the port exists with
      `smoothed` only.
    - **status** (1): a `ControllerStatus`; computed only when somebody asks. An input that is not
      finite counts as not valid.

    Args:
        size: m.
        tolerance: an error of this length counts as converged [m].
        restart_search: whether there is the port `restart_search`.
        blocked: whether there is the port `blocked`.
        smoothed: whether there is the port `sent_error`.

    Raises:
        ValueError: naming the bad value.
    """

    def __init__(
        self,
        size: int,
        *,
        tolerance: float = 1e-3,
        restart_search: bool = False,
        blocked: bool = False,
        smoothed: bool = False,
    ) -> None:
        super().__init__()
        check_counts(size=size)
        self._searches, self._sees = restart_search, blocked
        self._tolerance = check_positive("tolerance", tolerance)
        self._error = self.DeclareVectorInputPort("task_error", size)
        self._flags = [
            self.DeclareVectorInputPort(name, 1)
            for name in (
                "valid",
                "limited",
                "oscillating",
                "calmed",
                "following",
                *["restart_search"] * restart_search,
                *["blocked"] * blocked,
            )
        ]
        self._sent = self.DeclareVectorInputPort("sent_error", size) if smoothed else self._error
        inputs = (self._error, self._sent, *self._flags)
        self.DeclareVectorOutputPort(
            "status", 1, self._calc, prerequisites_of_calc={port.ticket() for port in inputs}
        )

    def _calc(self, context: Context, output: BasicVector) -> None:
        flags = [float(port.Eval(context)[0]) for port in self._flags]
        valid, limited, oscillating, calmed, following = flags[:5]
        error = length(self._error.Eval(context))
        output[0] = controller_status(
            valid=bool(valid) and isfinite(sum(flags) + error),
            error=error,
            tolerance=self._tolerance,
            limited=bool(limited),
            oscillating=bool(oscillating),
            calmed=bool(calmed),
            following=bool(following),
            restart_search=flags[5] if self._searches else RestartState.NONE,
            blocked=self._sees and bool(flags[-1]),
            settled=length(self._sent.Eval(context)) <= self._tolerance,
        )
