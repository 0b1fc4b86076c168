"""The calibrated URDF on TF, fed with the joint positions at which it is exact.

ros2 launch mukca_ros calibrated.launch.py calibration:=/path/to/calibrated
"""

from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def nodes(context: LaunchContext) -> list[Node]:
    """Return the correction of joint states, and the publisher of the calibrated URDF."""
    folder = Path(LaunchConfiguration("calibration").perform(context))
    urdf = (folder / "calibrated.urdf").read_text(encoding="utf-8")
    return [
        Node(
            package="mukca_ros",
            executable="true_joint_states",
            parameters=[{"calibration": str(folder)}],
        ),
        Node(
            package="robot_state_publisher",
            executable="robot_state_publisher",
            parameters=[{"robot_description": urdf}],
            remappings=[("joint_states", "joint_states_true")],
        ),
    ]


def generate_launch_description() -> LaunchDescription:
    """Return what ``ros2 launch`` starts."""
    text = "the folder that mukca solve --out wrote"
    argument = DeclareLaunchArgument("calibration", description=text)
    return LaunchDescription([argument, OpaqueFunction(function=nodes)])
