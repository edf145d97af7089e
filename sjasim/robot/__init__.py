"""The TurtleBot 2: its body, wheel kinematics, odometry and the execution of moves."""
