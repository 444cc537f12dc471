"""Write `fk_golden.json`: kinematics of three arms by roboticstoolbox-python.

The tests compare our arms with these numbers, so nothing here may import `fikm_drake` or read
`models/`: roboticstoolbox has its own tables, limits and arithmetic. Run it in an environment with
the extra `peers`:

    python tests/golden/make_golden.py            # write the file
    python tests/golden/make_golden.py --check    # compare with the file, write nothing

The file holds `about`, `versions`, `seed` and `arms`; each arm holds `source`, `frame` (what T is
the pose of), `labels` (one a configuration: zero, ready, …, random_0 to random_49) and the lists

    q  n numbers    joint positions [rad]
    T  4 x 4        pose of the end effector in the base frame [m]
    J  6 x n        geometric Jacobian in the base frame, at the end-effector point, rows [ω; v]
                    (roboticstoolbox's own order is [v; ω])

Random configurations are uniform within roboticstoolbox's limits. The zero pose may be outside
(Panda, joint 4).
"""

import argparse
import json
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
import roboticstoolbox as rtb
from roboticstoolbox.models.URDF.URDFRobot import URDFRobot

GOLDEN_FILE = Path(__file__).with_name("fk_golden.json")
SEED = 1993
RANDOM_CONFIGURATIONS = 50
CHECK_TOLERANCE = 1e-12

IIWA_URDF = "kuka_description/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf"
IIWA_OFFSET = "0.00043624"
"""x offset [m] of the frames of joints 2 and 4 in rtb-data's URDF; see `iiwa14`."""


def iiwa14() -> rtb.Robot:
    """The iiwa 14 of rtb-data's URDF, without that URDF's offsets of 0.44 mm.

    The URDF puts joint 2 at x = −0.43624 mm and joint 4 at x = +0.43624 mm in their parents'
    frames. KUKA's data sheet and the URDF of iiwa_stack have neither: axes 1 to 3 meet in one
    point, and so do axes 3 to 5.
    """

    def without_offset(urdf: str) -> str:
        for sign in ("-", ""):
            old = f'xyz="{sign}{IIWA_OFFSET} '
            if urdf.count(old) != 1:
                raise RuntimeError(
                    f"{IIWA_URDF}: expected {old!r} once, found it {urdf.count(old)} times"
                )
            urdf = urdf.replace(old, 'xyz="0 ')
        return urdf

    # The URDF names its meshes by a package name that rtb-data does not use.
    aliases = {"kuka_lbr_iiwa_support": "kuka_description/kuka_lbr_iiwa"}
    return URDFRobot(IIWA_URDF, patch=without_offset, extra_packages=aliases)


def evaluate(
    robot: rtb.Robot | rtb.DHRobot, q: np.ndarray, end: str | None
) -> tuple[np.ndarray, np.ndarray]:
    """Pose (4 x 4) and Jacobian (6 x n, [ω; v]) at `q`, of the link `end` or a DHRobot's tool."""
    if end is None:
        pose, jacobian = robot.fkine(q).A, robot.jacob0(q)
    else:
        pose, jacobian = robot.fkine(q, end=end).A, robot.jacob0(q, end=end)
    return pose, np.vstack((jacobian[3:], jacobian[:3]))


def golden_of(
    robot: rtb.Robot | rtb.DHRobot,
    named: dict[str, np.ndarray],
    rng: np.random.Generator,
    *,
    source: str,
    frame: str,
    end: str | None = None,
) -> dict:
    """One arm's entry of the file: the `named` configurations, then the random ones."""
    lower, upper = robot.qlim
    configurations = dict(named)
    for index in range(RANDOM_CONFIGURATIONS):
        configurations[f"random_{index}"] = rng.uniform(lower, upper)
    entry = {
        "source": source,
        "frame": frame,
        "labels": list(configurations),
        "q": [],
        "T": [],
        "J": [],
    }
    for q in configurations.values():
        pose, jacobian = evaluate(robot, q, end)
        for name, value in (("q", q), ("T", pose), ("J", jacobian)):
            entry[name].append(np.asarray(value, dtype=float).tolist())
    return entry


def make_golden() -> dict:
    """The whole content of the file."""
    puma560, panda, iiwa = rtb.models.DH.Puma560(), rtb.models.DH.Panda(), iiwa14()
    iiwa_ready = rtb.models.URDF.LBR().qr
    rngs = np.random.default_rng(SEED).spawn(3)
    arms = {
        "puma560": golden_of(
            puma560,
            {"zero": puma560.qz, "ready": puma560.qr, "nominal": puma560.qn},
            rngs[0],
            source="roboticstoolbox.models.DH.Puma560 "
            "(standard DH, d1 = 26.45 inch; no base or tool transform)",
            frame="frame 6 of the table, our end effector",
        ),
        "panda": golden_of(
            panda,
            {"zero": panda.qz, "ready": panda.qr},
            rngs[1],
            source="roboticstoolbox.models.DH.Panda "
            "(modified DH, tool Tz(0.103) Rz(-45 deg); no base transform)",
            frame="panda_link8 . Tz(0.103) . Rz(-45 deg), our end effector",
        ),
        "iiwa14": golden_of(
            iiwa,
            {"zero": np.zeros(7), "ready": iiwa_ready},
            rngs[2],
            source=f"rtb-data's {IIWA_URDF} "
            "with its x offsets of 0.43624 mm at joints 2 and 4 set to 0",
            frame="link tool0 = link_7 . Tz(0.126), our end effector "
            "(iiwa_stack: iiwa_link_7 . Tz(0.045))",
            end="tool0",
        ),
    }
    packages = ("roboticstoolbox-python", "rtb-data", "spatialmath-python", "numpy")
    return {
        "about": "Written by tests/golden/make_golden.py, which says what is what. "
        "m, rad; rows of J: [omega; v].",
        "versions": {"python": sys.version.split()[0]} | {name: version(name) for name in packages},
        "seed": SEED,
        "arms": arms,
    }


def to_json(golden: dict) -> str:
    """JSON with one configuration a line, so that a change of the file can be read as a diff."""
    head = {key: value for key, value in golden.items() if key != "arms"}
    lines = [json.dumps(head, indent=1)[:-2] + ",", ' "arms": {']
    for arm_index, (arm, entry) in enumerate(golden["arms"].items()):
        lines.append(f"  {json.dumps(arm)}: {{")
        for key_index, (key, value) in enumerate(entry.items()):
            comma = "," if key_index < len(entry) - 1 else ""
            if key in ("q", "T", "J"):
                rows = ",\n".join(f"    {json.dumps(row)}" for row in value)
                lines.append(f"   {json.dumps(key)}: [\n{rows}\n   ]{comma}")
            else:
                lines.append(f"   {json.dumps(key)}: {json.dumps(value)}{comma}")
        lines.append("  }" + ("," if arm_index < len(golden["arms"]) - 1 else ""))
    return "\n".join([*lines, " }", "}", ""])


def check(golden: dict, stored: dict) -> bool:
    """Print each arm's largest difference from the stored file; True if all are small."""
    good = True
    for arm, entry in golden["arms"].items():
        worst = max(
            np.abs(np.array(entry[key]) - np.array(stored["arms"][arm][key])).max()
            for key in ("q", "T", "J")
        )
        good = good and bool(worst <= CHECK_TOLERANCE)
        print(f"{arm}: largest difference {worst:.1e}")
    return good


def main() -> int:
    """Write or check the file; returns the exit status."""
    parser = argparse.ArgumentParser(
        description="Write tests/golden/fk_golden.json from roboticstoolbox-python."
    )
    parser.add_argument(
        "--check", action="store_true", help="compare with the stored file, write nothing"
    )
    arguments = parser.parse_args()
    golden = make_golden()
    if arguments.check:
        return 0 if check(golden, json.loads(GOLDEN_FILE.read_text(encoding="utf-8"))) else 1
    text = to_json(golden)
    if json.loads(text) != golden:
        raise RuntimeError("the JSON text does not hold the same numbers")
    GOLDEN_FILE.write_text(text, encoding="utf-8")
    print(f"wrote {GOLDEN_FILE} with {golden['versions']}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
