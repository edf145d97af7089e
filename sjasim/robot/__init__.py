"""The robot: MuJoCo model, wheel kinematics, odometry, event detection, and the controller that carries out moves.

There is one robot, a TurtleBot 2 with a differential drive. A second one would differ in `mjcf` (its model) and
perhaps in `diff_drive` (its kinematics), and would share the rest. Its files belong in this room, and its name in a
registry kind ``robot`` of `core.registry`, which does not exist yet; `mjcf` says what a model must contain.
"""
