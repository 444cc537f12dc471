"""What every differential-IK law offers, and how one is named."""

import dataclasses
from collections.abc import Callable
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array


@runtime_checkable
class Law(Protocol):
    """A pure function (J, dr) to a joint step; `DifferentialIk` and the controllers take any.

    A law with an attribute `takes_damping` that is true takes the supervisor's damping as a third
    argument of `step`.
    """

    def __call__(self, J: ArrayLike, dr: ArrayLike) -> Array:
        """The joint step (…,n) for a Jacobian (…,m,n) and a task error (…,m)."""

    def step(self, J: Array, dr: Array) -> Array:
        """The same for one (m,n) and one (m,), unchecked, for a control loop."""


LawLike: TypeAlias = Law | Callable[[Array, Array], Array]
"""A law, or a plain function (J, dr) to a joint step."""


class CallableLaw:
    """A plain function as a law.

    Args:
        function: (J, dr) to a joint step, for one (m,n) and one (m,).

    Example:
        >>> import numpy as np
        >>> CallableLaw(lambda J, dr: J.T @ dr).step(np.eye(2), np.ones(2)).tolist()
        [1.0, 1.0]
    """

    def __init__(self, function: Callable[[Array, Array], Array]) -> None:
        self.function = function

    def __call__(self, J: ArrayLike, dr: ArrayLike) -> Array:
        """The joint steps (…,n), one after the other."""
        J, dr = as_arrays(J, dr)
        lead = np.broadcast_shapes(J.shape[:-2], dr.shape[:-1])
        Js, drs = np.broadcast_to(J, lead + J.shape[-2:]), np.broadcast_to(dr, lead + dr.shape[-1:])
        steps = [self.step(Js[i], drs[i]) for i in np.ndindex(*lead)]
        return np.array(steps).reshape(*lead, J.shape[-1])

    def step(self, J: Array, dr: Array) -> Array:
        """The joint step (n,); NaN, which the guard holds, where the function's is of another shape."""
        step = np.asarray(self.function(J, dr), dtype=float)
        return step if step.shape == J.shape[1:] else np.full(J.shape[1], np.nan)

    def __repr__(self) -> str:
        return f"CallableLaw({getattr(self.function, '__name__', self.function)!s})"


def as_law(law: LawLike, size: int, num_joints: int, *, known: dict[str, type]) -> Law:
    """The law, checked by one call.

    Args:
        law: a `Law` or a plain function (J, dr) to a joint step.
        size: m.
        num_joints: n.
        known: the laws with names, for the message.

    Raises:
        ValueError: it is no law, raises, or gives something else than n finite numbers.
    """
    valid = f"a law is one of {', '.join(known)} or a function (J (m,n), dr (m,)) to (n,)"
    if isinstance(law, (str, type)) or not (callable(law) or hasattr(law, "step")):
        raise ValueError(f"law must be an object, not {law!r}: {valid}")
    if dataclasses.is_dataclass(law):  # YAML writes fields after __init__ has looked at them
        law = dataclasses.replace(law)
    checked: Any = law if hasattr(law, "step") else CallableLaw(law)
    # A rule base knows only J within its range, a function need not bear a singular one.
    J = (0.0 if type(law) in known.values() else 1.0) * (0.1 * np.eye(size, num_joints) + 0.01)
    function = checked.function if isinstance(checked, CallableLaw) else checked.step
    try:
        step = np.asarray(function(J, np.full(size, 1e-3)), dtype=float)
    except Exception as error:
        raise ValueError(
            f"law {law!r} fails for J ({size},{num_joints}) and dr ({size},): {error}; {valid}"
        ) from error
    if step.shape != (num_joints,) or not np.isfinite(step).all():
        raise ValueError(
            f"law {law!r} must give {num_joints} finite numbers for J ({size},{num_joints}) and "
            f"dr ({size},), got {step.tolist()!r}; {valid}"
        )
    return checked


def takes_damping(law: LawLike) -> bool:
    """True if the law's `step` takes a damping."""
    return bool(getattr(law, "takes_damping", False))


def as_arrays(J: ArrayLike, dr: ArrayLike) -> tuple[Array, Array]:
    """A Jacobian (…,m,n) and a task error (…,m); ValueError, naming the shapes, if they do not fit."""
    J, dr = np.asarray(J, dtype=float), np.asarray(dr, dtype=float)
    if J.ndim < 2 or dr.ndim < 1 or not J.shape[-2] == dr.shape[-1] > 0 < J.shape[-1]:
        raise ValueError(f"J must be (…, m, n) and dr (…, m), got {J.shape} and {dr.shape}")
    return J, dr
