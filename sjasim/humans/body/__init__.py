"""What people's bodies are: anatomy, MJCF, kinematics, inverse dynamics."""
