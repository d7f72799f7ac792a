"""Readings in whole steps, as an instrument with so many digits gives them."""


def quantised(value: float, step: float) -> float:
    """Return a `value` rounded to a whole multiple of a `step`; as it is where that is 0, or it is no number."""
    return step * round(value / step, 0) if step > 0.0 else value
