"""A robot that a person moves: Drake's pose sliders, our controller, a light for the status."""

from math import pi
from pathlib import Path

import numpy as np
from pydrake.geometry import Box, Meshcat, MeshcatParams, Rgba
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, OutputPort

from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.control.status import ControllerStatus
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.simulation.log_info import LogInfo, names_of, versions
from fikm_drake.simulation.recorder import POSE_COLUMNS, RowCollector
from fikm_drake.simulation.run_log import RunLog
from fikm_drake.simulation.scenario import Fuzzy, Model, Pose, Scenario
from fikm_drake.simulation.scenario import Path as TargetPath
from fikm_drake.simulation.scenario.build_scenario import build_scenario
from fikm_drake.simulation.scenario.motion import Motion
from fikm_drake.simulation.scenario.robots import MODEL_SUFFIXES

RATE = 100.0
"""Rate of the controller [Hz]."""
SPEED = 1.5
"""Largest joint speed, if the robot's own limits are not lower [rad/s or m/s]."""
LIGHTS = {
    ControllerStatus.CONVERGED: Rgba(0.2, 0.7, 0.3),
    ControllerStatus.TRACKING: Rgba(0.2, 0.5, 0.9),
    ControllerStatus.INVALID_INPUT: Rgba(0.1, 0.1, 0.1),
    ControllerStatus.STUCK: Rgba(0.8, 0.1, 0.1),
}
"""Colours of the light; any other status is orange."""
STOP = "Stop"


class Teleop:
    """Sliders for the tool's pose in Meshcat, the robot that follows them, and a log.

        teleop = fd.Teleop("panda")
        print(teleop.meshcat.web_url())
        log = teleop.run(seconds=60.0)

    Green: the tool is at the sliders' pose, blue: on its way, orange: a limit or an oscillation holds it
    back, red: stuck.

    Args:
        robot: name of an arm, path of a DH table or of a model file.
        frame: of a model, the tool's frame; None: that of the body furthest out.
        port: of the page; None: a free one.
        meshcat: an open Meshcat to use; None: one of its own.

    Raises:
        FileNotFoundError: there is no such robot.
        ValueError: it is no robot, or the port is taken.
    """

    def __init__(
        self,
        robot: str,
        *,
        frame: str | None = None,
        port: int | None = None,
        meshcat: Meshcat | None = None,
    ) -> None:
        model = robot.endswith(MODEL_SUFFIXES)
        if frame is not None and not model:
            raise ValueError(f"frame {frame!r} is not used: {robot} is no model file")
        if meshcat is None:
            try:
                meshcat = Meshcat(MeshcatParams(port=port))
            except RuntimeError as error:
                raise ValueError(f"port {port} cannot be had: {error}") from error
        self.meshcat = meshcat
        self._scenario = _at_rest(Model(robot, frame or "") if model else robot)
        self._built = build_scenario(self._scenario, meshcat=meshcat, target=self._sliders)
        self._rows: RowCollector | None = None

    def run(self, *, seconds: float | None = None, file: str | Path | None = None) -> RunLog:
        """Follow the sliders in real time until `seconds` are over or the button `Stop` is pressed.

        Args:
            seconds: how long [s]; None: until the button.
            file: a log that grows meanwhile.

        Returns:
            The log: desired and actual pose, joints, errors, gain and status, a row a control cycle.
        """
        built, wired = self._built, self._built.wired
        simulator = Simulator(built.diagram)
        simulator.set_target_realtime_rate(1.0)
        root = simulator.get_mutable_context()
        built.set_start(root)
        simulator.Initialize()
        n = built.chain.num_joints
        columns = {name: [f"{name}_{c}" for c in POSE_COLUMNS] for name in ("desired", "actual")}
        columns["q"] = [f"q_{i}" for i in range(1, n + 1)]
        columns |= {"gain": ["gain"], "status": ["status"]}
        info = LogInfo(columns, names={"status": names_of(ControllerStatus)}, versions=versions())
        rows = self._rows = RowCollector(info, file)
        presses = self._button()
        cycle = 0
        try:
            while seconds is None or cycle <= seconds * RATE:
                simulator.AdvanceTo(cycle / RATE)
                rows.add(cycle / RATE, self._row(root))
                self._show(int(_eval(wired.logged["status"], root)[0]))
                if self.meshcat.GetButtonClicks(STOP) > presses:
                    break
                cycle += 1
        finally:
            self.meshcat.DeleteButton(STOP)
            rows.close()
        return self.log()

    def log(self) -> RunLog:
        """The log so far.

        Raises:
            ValueError: it did not run yet.
        """
        if self._rows is None:
            raise ValueError("the robot was not moved yet: call run")
        return self._rows.log()

    def _sliders(self, builder: DiagramBuilder, motion: Motion) -> OutputPort:
        from pydrake.visualization import MeshcatPoseSliders  # slow to load, used here only

        pose = motion.pose(0.0)
        low, high = pose.translation() - 0.6, pose.translation() + 0.6
        sliders = builder.AddNamedSystem(
            "sliders",
            MeshcatPoseSliders(
                self.meshcat,
                initial_pose=pose,
                lower_limit=np.concatenate([[-pi] * 3, low]),
                upper_limit=np.concatenate([[pi] * 3, high]),
            ),
        )
        self._desired = sliders.get_output_port()
        return self._desired

    def _row(self, root: Context) -> list[np.ndarray]:
        wired, chain = self._built.wired, self._built.chain
        q = np.array(self._built.positions(root))
        actual = RigidTransform(chain.forward_kinematics(q))
        desired = self._desired.Eval(self._desired.get_system().GetMyContextFromRoot(root))
        row = [_pose_numbers(desired), _pose_numbers(actual), q]
        return row + [_eval(wired.logged[name], root) for name in ("gain", "status")]

    def _button(self) -> int:
        self.meshcat.AddButton(STOP, "Escape")
        self.meshcat.SetObject("status", Box(0.08, 0.08, 0.02), LIGHTS[ControllerStatus.TRACKING])
        self.meshcat.SetTransform("status", RigidTransform([-0.3, 0.3, 0.0]))
        self._shown = -1
        return self.meshcat.GetButtonClicks(STOP)

    def _show(self, status: int) -> None:
        """The light, which is sent only when it changes."""
        if status != self._shown:
            colour = LIGHTS.get(ControllerStatus(status), Rgba(0.95, 0.6, 0.1))
            self.meshcat.SetProperty(
                "status/<object>", "color", [colour.r(), colour.g(), colour.b(), 1.0]
            )
            self._shown = status


def _at_rest(robot: Model | str) -> Scenario:
    """A robot whose target is where its tool is."""
    config = FuzzyIkConfig(law=FuzzyMapping.iterated(), velocity_limits=[SPEED])
    blank = Scenario(robot=robot, target=TargetPath(poses=[Pose([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])]))
    tool = RigidTransform(blank.chain().forward_kinematics(blank.start()))
    pose = Pose(tool.translation().tolist(), [], tool.rotation().ToQuaternion().wxyz().tolist())
    return Scenario(
        robot=robot, controller=Fuzzy(config), target=TargetPath(poses=[pose]), control_rate=RATE
    )


def _eval(port: OutputPort, root: Context) -> np.ndarray:
    return port.Eval(port.get_system().GetMyContextFromRoot(root))


def _pose_numbers(pose: RigidTransform) -> np.ndarray:
    return np.concatenate([pose.rotation().ToQuaternion().wxyz(), pose.translation()])
