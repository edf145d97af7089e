"""Analysis of recorded sessions: measures, delays, accuracy, figures, and calibration of the human timing model."""
