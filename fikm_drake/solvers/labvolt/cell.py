"""The LabVolt 5250 as a cell has it: the hand's roll and a gripper in the URDF, servo counts in a file.

Neither changes where the tool is, so every solver here serves the arm with them: joints 1 to 4 are those of
`models/labvolt5250.yaml`, `roll` turns the hand about itself, `left` and `right` close the fingers.
"""

import re
from pathlib import Path
from string import Template

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.files import write_whole
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.labvolt.geometry import MODEL, labvolt, to_servo_counts

ROLL_AT, FINGERS_AT = 0.09, 0.12
"""From the wrist along the hand: where it rolls, and where the fingers begin [m]. Ours: the sources give the
tool's distance only."""
OPENING, FINGER, THICK = 0.03, 0.05, 0.008
"""Sizes of a finger: its way from closed to open, its length, half its thickness [m]."""
GRIP_FORCE, GRIP_SPEED = 20.0, 0.1
"""Limits of a finger [N], [m/s]."""
HAND = Template("""\
  <link name="hand">
    <inertial>
      <origin xyz="$middle 0 0" />
      <mass value="0.1" />
      <inertia ixx="5e-5" ixy="0" ixz="0" iyy="5e-5" iyz="0" izz="5e-5" />
    </inertial>
    <visual name="body">
      <origin xyz="$middle 0 0" />
      <geometry>
        <box size="$body 0.08 0.03" />
      </geometry>
    </visual>
  </link>
  <joint name="roll" type="continuous">
    <parent link="link4" />
    <child link="hand" />
    <origin xyz="$roll_at 0 0" rpy="0 0 0" />
    <axis xyz="1 0 0" />
    <limit effort="20" velocity="1e9" />
  </joint>
$fingers
  <link name="tool" />
  <joint name="tool_joint" type="fixed">
    <parent link="hand" />
    <child link="tool" />
    <origin xyz="$tool 0 0" rpy="0 0 0" />
  </joint>
""")
FINGER_LINK = Template("""\
  <link name="$name">
    <inertial>
      <origin xyz="$half $inner 0" />
      <mass value="0.02" />
      <inertia ixx="5e-6" ixy="0" ixz="0" iyy="5e-6" iyz="0" izz="5e-6" />
    </inertial>
    <visual name="$name">
      <origin xyz="$half $inner 0" />
      <geometry>
        <box size="$length $thick 0.02" />
      </geometry>
    </visual>
    <collision name="$name">
      <origin xyz="$half $inner 0" />
      <geometry>
        <box size="$length $thick 0.02" />
      </geometry>
      <drake:proximity_properties>
        <drake:mu_static value="1.0" />
        <drake:mu_dynamic value="0.9" />
      </drake:proximity_properties>
    </collision>
  </link>
  <joint name="$name" type="prismatic">
    <parent link="hand" />
    <child link="$name" />
    <origin xyz="$at 0 0" rpy="0 0 0" />
    <axis xyz="0 $side 0" />
    <limit effort="$force" lower="0" upper="$opening" velocity="$speed" />
  </joint>
""")
MOTOR = Template("""\
  <transmission name="${name}_transmission">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="$name" />
    <actuator name="${name}_motor" />
  </transmission>
""")


def gripper_urdf() -> str:
    """URDF of the LabVolt 5250 with roll and gripper; the frame `tool` is where it is without.

        parser.AddModelsFromString(fd.labvolt.gripper_urdf(), "urdf")

    Seven joints: joint1 to joint4, roll [rad], left and right [m], 0 closed. The fingers are boxes that
    touch at the middle of the hand and reach a little past the tool's point.
    """
    text = load_arm(MODEL).to_urdf()
    reach = labvolt().lengths[2]
    text = text.replace(f'<robot name="{MODEL}"', f'<robot name="{MODEL}_gripper"')
    # The last bar ends where the hand begins to roll.
    link4 = text.index('<link name="link4">')
    end = text.index("</link>", link4)
    bar = re.sub(r'length="[\d.]+"', f'length="{ROLL_AT}"', text[link4:end])
    bar = re.sub(r'<origin xyz="0\.0827 ', f'<origin xyz="{ROLL_AT / 2} ', bar)
    text = text[:link4] + bar + text[end:]
    fingers = "".join(
        FINGER_LINK.substitute(
            name=name,
            half=FINGER / 2,
            inner=side * THICK,
            length=FINGER,
            thick=2 * THICK,
            at=FINGERS_AT - ROLL_AT,
            side=side,
            force=GRIP_FORCE,
            opening=OPENING,
            speed=GRIP_SPEED,
        )
        for name, side in (("left", 1), ("right", -1))
    )
    hand = HAND.substitute(
        middle=(FINGERS_AT - ROLL_AT) / 2,
        body=FINGERS_AT - ROLL_AT,
        roll_at=ROLL_AT,
        tool=reach - ROLL_AT,
        fingers=fingers.rstrip("\n"),
    )
    start = text.index('  <link name="tool" />')
    end = text.index("</joint>", start) + len("</joint>\n")
    text = text[:start] + hand + text[end:]
    motors = "".join(MOTOR.substitute(name=name) for name in ("roll", "left", "right"))
    last = text.rindex("</transmission>") + len("</transmission>\n")
    return text[:last] + motors + text[last:]


def save_servo_counts(path: str | Path, times: ArrayLike, angles: ArrayLike) -> None:
    """Write servo counts along a motion as CSV, for the arm's controller.

    Columns: time_s, base_deg, shoulder, elbow, wrist. The source gives counts of the last three; the base
    is left in degrees.

    Args:
        path: of the file; it is written whole or not at all.
        times: (N,) [s].
        angles: (N,4) yaw and absolute θ_1, θ_2, θ_3 [rad], as `LabVoltIk` has them on its port `angles`.

    Raises:
        ValueError: other shapes, or numbers that are not finite.
        OSError: the file cannot be written.
    """
    times, angles = np.asarray(times, dtype=float), np.asarray(angles, dtype=float)
    if times.ndim != 1 or angles.shape != (len(times), 4):
        raise ValueError(f"angles must be ({times.size}, 4), one row a time, got {angles.shape}")
    if not np.isfinite(times).all() or not np.isfinite(angles).all():
        raise ValueError("times and angles must be finite")
    counts = to_servo_counts(angles[:, 1:])
    lines = ["time_s,base_deg,shoulder,elbow,wrist"]
    for t, base, row in zip(times.tolist(), np.rad2deg(angles[:, 0]).tolist(), counts.tolist()):
        lines.append(f"{t:.6g},{base:.4f},{','.join(map(str, row))}")
    write_whole(path, "\n".join([*lines, ""]))
