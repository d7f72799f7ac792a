"""What the controller is given and gives, as plain data and as messages."""
