"""What was measured: placements checked against the robot, and how well a model predicts them."""
