"""What core and adviser exchange: observations one way, beliefs the other. Both are frozen values."""
