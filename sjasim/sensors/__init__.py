"""What the four sensors and their clients make of the stage: skeletons, then events."""
