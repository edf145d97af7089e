"""sjasim: three dancers and a robot, in simulation, to try group coordination before people are recruited."""
