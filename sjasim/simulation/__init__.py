"""Everything that needs MuJoCo: physics, control loop, recorder, rendering."""
