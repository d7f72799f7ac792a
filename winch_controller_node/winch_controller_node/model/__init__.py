"""Models: linear state space, the parts of the loop, regulator and Kalman filter."""
