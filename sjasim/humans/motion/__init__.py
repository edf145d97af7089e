"""Motion of the dancers: from cues to footsteps, reference trajectories and balance."""
