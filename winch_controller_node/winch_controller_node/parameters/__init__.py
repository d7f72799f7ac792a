"""The controller's parameters: what is believed of plant, winch, sea and sensors, and how laws and modes act."""
