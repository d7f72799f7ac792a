"""The sensors on unit and cable: sampled, noisy, late and faulty views of the truth."""
