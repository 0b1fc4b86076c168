"""Republish joint states so that calibrated.urdf is exact: a node for ROS 2.

    ros2 run mukca_ros true_joint_states --ros-args -p calibration:=/path/to/calibrated

Published are virtual joint positions: those at which the URDF has the flange where the calibrated
arm, which bends, truly has it. So TF is that of the arm. Controllers stay on `joint_states`, which
the arm reports. With fewer than six joints there are none: published is where the joints truly are.
Near a singular posture there may be none, either: a warning says so, and nothing is published.

On `flange_pose` stands where the flange truly is, and how well that is known: a covariance of its
place and turn in the base. A calibration by the paper's method has none, and publishes no pose.
Places in the base are known to millimetres, movements far better: with `-p relative_to:=Q1,Q2,..`
[rad] the covariance is that of the movement from there. With `-p tool:=LINK` both are a tool's, a
link that stands still on the flange; best known is the ball's, `ball_link`.
"""

import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState

import mukca
from mukca.solver.calibration import quaternion_of


class TrueJointStates(Node):
    """Listens to joint states, and publishes them corrected."""

    def __init__(self) -> None:
        super().__init__("true_joint_states")
        self.arm = mukca.load_calibration(self._text("calibration"))
        self.tool = self._text("tool") or None
        start = self._text("relative_to")
        self.start = [float(word) for word in start.split(",")] if start else None
        self.publisher = self.create_publisher(JointState, "joint_states_true", 10)
        self.flange_poses = self.create_publisher(
            PoseWithCovarianceStamped, "flange_pose", 10
        )
        self.create_subscription(JointState, "joint_states", self.correct, 10)

    def _text(self, name: str) -> str:
        """Return a parameter, empty where it is not given."""
        return self.declare_parameter(name, "").get_parameter_value().string_value

    def correct(self, message: JointState) -> None:
        """Publish the virtual positions of a message's joints."""
        names = self.arm.robot.joint_names
        if not set(names) <= set(message.name[: len(message.position)]):
            return  # a gripper's, another arm's, or of speeds alone
        places = [message.name.index(name) for name in names]
        read = [message.position[i] for i in places]
        try:
            there = (
                self.arm.virtual_positions
                if len(names) > 5
                else self.arm.true_positions
            )
            positions = there(read)
        except mukca.MukcaError as error:
            self.get_logger().warning(str(error), throttle_duration_sec=1.0)
            return
        if self.arm.document.posterior is not None:
            self.flange_poses.publish(self.pose(read, message.header.stamp))
        for i, position in zip(places, positions, strict=True):
            message.position[i] = float(position)
        self.publisher.publish(message)

    def pose(self, read: list[float], stamp: object) -> PoseWithCovarianceStamped:
        """Return the pose of the flange, or of a tool, in the base, and its covariance."""
        T = self.arm.flange(read, tool=self.tool)
        pose = PoseWithCovarianceStamped()
        pose.header.stamp, pose.header.frame_id = stamp, self.arm.robot.base
        place, turn = pose.pose.pose.position, pose.pose.pose.orientation
        place.x, place.y, place.z = T[:3, 3].tolist()
        turn.x, turn.y, turn.z, turn.w = quaternion_of(T[None, :3, :3])[0].tolist()
        covariance = self.arm.deviation(read, relative_to=self.start, tool=self.tool)
        pose.pose.covariance = covariance.ravel().tolist()
        return pose


def main() -> None:
    """Run the node until it is interrupted."""
    rclpy.init()
    rclpy.spin(TrueJointStates())
