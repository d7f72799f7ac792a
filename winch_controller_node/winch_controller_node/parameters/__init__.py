"""The controller's parameters: the assumed plant, winch, sea and sensors, and how laws and modes act."""
