r"""Republish joint states with the joints where they truly are: a node for ROS 2.

    ros2 run robot_state_publisher robot_state_publisher calibrated/compensated.urdf \
        --ros-args -r joint_states:=joint_states_true
    python true_joint_states.py calibrated/calibration.json

Controllers stay on `joint_states`, which the arm reports; TF is then that of the calibrated arm.
"""

import sys

import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState

import mukca


class TrueJointStates(Node):
    """Listens to joint states, and publishes them corrected."""

    def __init__(self, file: str) -> None:
        super().__init__("true_joint_states")
        self.calibrated = mukca.load_calibration(file).calibrated
        self.publisher = self.create_publisher(JointState, "joint_states_true", 10)
        self.create_subscription(JointState, "joint_states", self.correct, 10)

    def correct(self, message: JointState) -> None:
        """Publish where the joints of a message truly are."""
        names = self.calibrated.robot.joint_names
        if not set(names) <= set(message.name[: len(message.position)]):
            return  # a gripper's, another arm's, or of speeds alone
        places = [message.name.index(name) for name in names]
        read = [message.position[i] for i in places]
        for i, true in zip(places, self.calibrated.true_positions(read), strict=True):
            message.position[i] = float(true)
        self.publisher.publish(message)


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(TrueJointStates(sys.argv[1]))
