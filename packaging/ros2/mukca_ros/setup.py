"""The ROS 2 package, as ``colcon build`` installs it."""

from setuptools import setup

setup(
    name="mukca_ros",
    version="1.0.0",
    packages=["mukca_ros"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/mukca_ros"]),
        ("share/mukca_ros", ["package.xml"]),
        ("share/mukca_ros/launch", ["launch/calibrated.launch.py"]),
    ],
    install_requires=["setuptools", "mukca"],
    license="Apache-2.0",
    description="A calibrated arm in ROS 2",
    entry_points={
        "console_scripts": ["true_joint_states = mukca_ros.true_joint_states:main"],
    },
)
