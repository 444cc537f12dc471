"""A small symmetric system solved in plain numbers, in half the time of numpy's call for six rows."""

from collections.abc import Callable
from functools import cache

from fikm_drake.arrays import Array

MOST_ROWS = 8
"""For more rows numpy's solver is faster."""

Solve = Callable[[Array, Array, Array], list[float]]


@cache
def written_out_solve(m: int) -> Solve:
    """A function (M (m,m), d (m,), b (m,)) -> x with (M + diag d) x = b, M symmetric, without pivoting.

    It is Gauss's elimination of the lower triangle with every loop written out, so that each entry is a
    variable with a name; with lists and indices it would take three times as long. For three rows:

        f = a10 * p0                    # p0 = 1 / a00
        a11 -= f * a10
        b1 -= f * b0
        ...
        b0 = (b0 - a10 * b1 - a20 * b2) * p0

    Raises:
        ZeroDivisionError: by the function, M + diag d is singular.
    """
    rows = range(m)
    names = ", ".join(f"({''.join(f'a{i}{j}, ' for j in rows)})" for i in rows)
    lines = [f"{names}, = M.tolist()"]
    for x in "db":
        lines.append(f"{''.join(f'{x}{i}, ' for i in rows)} = {x}.tolist()")
    lines += [f"a{i}{i} += d{i}" for i in rows]
    for k in rows:
        lines.append(f"p{k} = 1.0 / a{k}{k}")
        for i in rows[k + 1 :]:
            lines.append(f"f = a{i}{k} * p{k}")
            lines += [f"a{i}{j} -= f * a{j}{k}" for j in rows[k + 1 : i + 1]]
            lines.append(f"b{i} -= f * b{k}")
    for k in reversed(rows):
        known = "".join(f" - a{i}{k} * b{i}" for i in rows[k + 1 :])
        lines.append(f"b{k} = (b{k}{known}) * p{k}")
    lines.append(f"return [{', '.join(f'b{i}' for i in rows)}]")
    scope: dict[str, Solve] = {}
    exec("def solve(M, d, b):\n    " + "\n    ".join(lines), scope)
    return scope["solve"]
