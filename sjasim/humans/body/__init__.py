"""Bodies of the dancers: anatomy, MuJoCo model, kinematics and inverse dynamics.

To write a body of your own, implement `body_model.BodyModel` and name the class with ``--body.model module:Class``.
"""
