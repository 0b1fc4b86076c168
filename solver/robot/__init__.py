"""What a robot is: its chain of joints as a URDF describes it, its kinematics, its parameters."""
