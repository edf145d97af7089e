"""Methods that decide when the robot moves, and the synchrony equations they share; one file per method."""
