"""The crane: where its boom tip is by slew, luff, knuckle and extension. Pure, shared by ship and controller."""
