"""Time in the logs of ships: seconds, Unix time, dates of all forms, clocks, hhmmss numbers, days, weeks of GPS.

Whatever is found out about a time is said in a note. What can be read in two ways is refused with the option that
decides.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from datetime import datetime, timezone

import numpy as np
from heave_node.numerics.arrays import Array

DAY, WEEK = 86400.0, 604800.0
EARLIEST_UNIX = 1e8
"""A time from this on is a date (3 March 1973); below, it counts from some start of its own [s]."""
DATE_ORDERS = ("dmy", "mdy")
"""Ways to read 01/03/2025: day or month first."""
_EPOCHS = (
    (6.2e17, 6.6e17, 1e-7, 62135596800.0, "ticks of .NET, 100 ns from the year 1"),
    (1.2e17, 1.4e17, 1e-7, 11644473600.0, "a FILETIME, 100 ns from 1601"),
    *((1e17, math.inf, 1e-9, 0.0, "nanoseconds of Unix time"), (1e14, 1e17, 1e-6, 0.0, "microseconds of Unix time")),
    (1e11, 1e14, 1e-3, 0.0, "milliseconds of Unix time"),
    (6.2e10, 6.6e10, 1.0, 62135596800.0, "seconds from the year 1"),
    (2.7e9, 4.3e9, 1.0, 2082844800.0, "seconds from 1904"),
)
"""Times of a date: between which numbers, seconds per unit, 1970 in them [s], and name. 1904 is LabVIEW's."""
_HEADING_UNITS = {
    **{"ms": 1e-3, "msec": 1e-3, "milliseconds": 1e-3, "us": 1e-6, "microseconds": 1e-6, "ns": 1e-9},
    **{"min": 60.0, "mins": 60.0, "minutes": 60.0, "h": 3600.0, "hr": 3600.0, "hrs": 3600.0, "hours": 3600.0},
}
"""Unit that a heading such as `time_ms` states [s]."""
_DAY_ZEROS = ((7e5, 8e5, 719529.0, "Matlab"), (2e4, 8e4, 25569.0, "Excel"))
"""Serial days: between which numbers, number of 1 January 1970, and who counts so."""
_GPS_EPOCH, _LEAP_SECONDS = 315964800.0, 18.0
"""Start of GPS time [s of Unix time], and by how much it is ahead of UTC since 2017 [s]."""
_NAMES = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_MONTHS = {name: number for number, name in enumerate(_NAMES, 1)}
_TEXT = re.compile(
    r"(?:(?P<compact>\d{8})|(?P<a>\d{1,4})(?P<sign>[-/. ])(?P<b>\d{1,2}|[A-Za-z]{3})(?P=sign)(?P<c>\d{1,4}))?"
    r"[T ]*"
    r"(?:(?P<hour>\d{1,2}):(?P<minute>\d{2})(?::(?P<second>\d{2}(?:[.,]\d*)?))?"
    r"|(?P<clock>\d{6}(?:[.,]\d*)?))?"
    r"\s*(?P<half>[AaPp][Mm])?\s*(?:UTC|GMT)?\s*(?P<zone>[Zz]|[+-]\d{2}(?::?\d{2})?)?"
)


class TimeError(ValueError):
    """Times that cannot be read, or in two ways; the message says which and what to do, without the file's name."""


def unix_time(text: str) -> float:
    """Return the Unix time of a date and time [s]; NaN where `text` is none. Without a zone it is UTC.

    The form is ISO 8601, or a date with its year last whose parts are parted by points, day first.
    """
    found = _TEXT.fullmatch(text.strip())
    day = _midnight(found, order="") if found else None
    return math.nan if found is None or day is None else day + _clock(found)


def time_words(time: float) -> str:
    """Return a `time` [s] as a person reads it: a date where it is Unix time, else seconds."""
    if time < EARLIEST_UNIX:
        return f"t = {time:.3f} s"
    return datetime.fromtimestamp(time, tz=timezone.utc).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _midnight(found: re.Match[str], order: str) -> float | None:
    """Return the Unix time of a match's date at 0 h [s]; None where there is none."""
    if found["compact"]:
        year, month, day = int(found["compact"][:4]), int(found["compact"][4:6]), int(found["compact"][6:])
    elif found["a"] is None:
        return None
    else:
        parts = [_MONTHS.get(part.lower(), 0) if part.isalpha() else int(part) for part in found.group("a", "b", "c")]
        if len(found["a"]) == 4:
            year, month, day = parts
        elif len(found["c"]) not in (2, 4):
            return None
        else:
            month_first = order == "mdy" and not found["b"].isalpha()
            if not order and found["sign"] != "." and not found["b"].isalpha():
                return None
            day, month, year = (parts[1], parts[0], parts[2]) if month_first else parts
            year += 2000 if year < 100 else 0
    try:
        return datetime(year, month, day, tzinfo=timezone.utc).timestamp()
    except ValueError:
        return None


def _clock(found: re.Match[str]) -> float:
    """Return a match's time of the day less its zone [s]; NaN where it is none."""
    if found["clock"]:
        texts = found["clock"][:2], found["clock"][2:4], found["clock"][4:]
    else:
        texts = found["hour"] or "0", found["minute"] or "0", found["second"] or "0"
    hour, minute, second = (float(text.replace(",", ".")) for text in texts)
    if found["half"]:
        hour = hour % 12.0 + (12.0 if found["half"].lower() == "pm" else 0.0)
    if hour > 24.0 or minute >= 60.0 or second >= 61.0:
        return math.nan
    zone = (found["zone"] or "").upper().replace("Z", "").replace(":", "")
    offset = float(f"{zone[0]}1") * (3600.0 * int(zone[1:3]) + 60.0 * int(zone[3:] or "0")) if zone else 0.0
    return 3600.0 * hour + 60.0 * minute + second - offset


def time_of_texts(texts: Sequence[str], order: str = "") -> tuple[Array, list[str]]:
    """Return the times of dates and clocks [s], and what was found out about them.

    Parameters
    ----------
    texts : one for each sample
    order : of dates with the year last, one of DATE_ORDERS; "": as the dates themselves show

    Raises TimeError for texts of which none is a time, and for dates that can be read in two ways.
    """
    found = [_TEXT.fullmatch(text.strip()) for text in texts]
    dates = {match.group("a", "sign", "b", "c") for match in found if match and match["a"]}
    notes = []
    if not order:
        order = _order_of(dates)
        notes += [f"time: dates read with the {'day' if order == 'dmy' else 'month'} first"] if order else []
    midnights: dict[str, float | None] = {}
    time = np.full(len(texts), math.nan)
    for index, match in enumerate(found):
        if match is None:
            continue
        date = match.group(0)[: match.end("c")] if match["a"] else match["compact"] or ""
        if date not in midnights:
            midnights[date] = _midnight(match, order) if date else 0.0
        midnight = midnights[date]
        has_clock = match["hour"] is not None or match["clock"] is not None
        if midnight is not None and (date or has_clock):
            time[index] = midnight + _clock(match)
    if not np.isfinite(time).any():
        raise TimeError(f"{texts[0]!r} is neither a number nor a time as in 2025-03-01T12:00:00.5Z")
    if not any(midnights):
        notes.append("time: of the day alone, without a date")
        time, words = unwrapped(time)
        notes += words
    time, words = _past_leap_second(found, time)
    return time, notes + words


def _past_leap_second(found: Sequence[re.Match[str] | None], time: Array) -> tuple[Array, list[str]]:
    """Return times with what follows a second 60 at the end of a day one second later, and what was done."""
    leaps = [i for i, match in enumerate(found) if match and (match["second"] or "").startswith("60")]
    last = next((i for i in reversed(leaps) if time[i] % DAY < 1.0), None)
    if last is None or last + 1 == time.size or not time[last + 1] <= time[last]:
        return time, []
    time[last + 1 :] += 1.0
    return time, ["time: passes a leap second: counted on through it"]


def _order_of(dates: Iterable[tuple[str | None, ...]]) -> str:
    """Return the order of dates (a, sign, b, c) with the year last and a number as month; "" where there is none."""
    last = [(a, sign, b, c) for a, sign, b, c in dates if a and b and len(a) < 4 and b.isdigit()]
    if not last:
        return ""
    if any(int(a) > 12 or sign == "." for a, sign, _, _ in last):
        return "dmy"
    if any(int(b) > 12 for _, _, b, _ in last):
        return "mdy"
    a, sign, b, c = last[0]
    raise TimeError(
        f"the date {a}{sign}{b}{sign}{c} can be read with the day or the month first: say --date-order dmy or mdy "
        "(in a mapping file: date_order)"
    )


def time_of_numbers(numbers: Array, heading: str = "", scale: float = 1.0) -> tuple[Array, list[str]]:
    """Return times [s] of numbers, and what was found out about them.

    Parameters
    ----------
    numbers : shape (n,); NaN where there is none
    heading : of their column, whose unit counts
    scale : of the numbers to seconds; other than 1 it is all that is done to them
    """
    if scale != 1.0:
        return numbers * scale, []
    words = re.split(r"[^a-z]+", heading.lower())
    unit = next((_HEADING_UNITS[word] for word in words if word in _HEADING_UNITS), 0.0)
    if unit:
        return numbers * unit, [f"time: taken in units of {unit:g} s, as its heading says"]
    time, notes = from_1970(numbers)
    if notes:
        return time, notes
    for attempt in (_as_days, _as_clock_numbers):
        time, notes = attempt(numbers)
        if notes:
            break
    time, wrapped = unwrapped(time)
    return time, notes + wrapped


def from_1970(numbers: Array) -> tuple[Array, list[str]]:
    """Return `numbers` of another unit or start than Unix seconds as these [s], and what was done; others as given."""
    middle = float(np.nanmedian(numbers))
    for least, most, unit, zero, name in _EPOCHS:
        if least < middle < most:
            return numbers * unit - zero, [f"time: taken as {name}"]
    return numbers, []


def _as_days(numbers: Array) -> tuple[Array, list[str]]:
    """Return serial days of Excel or Matlab as Unix time; no sensor is read a thousand times in a serial "second"."""
    steps = np.diff(numbers[np.isfinite(numbers)])
    moved = steps[steps > 0.0]
    middle = float(np.nanmedian(numbers))
    for least, most, zero, name in _DAY_ZEROS:
        if least < middle < most and moved.size and float(np.median(moved)) < 2e-4:
            time = (numbers - zero) * DAY
            return np.round(time, 4 if name == "Excel" else 3), [f"time: taken as serial days of {name}"]
    return numbers, []


def _as_clock_numbers(numbers: Array) -> tuple[Array, list[str]]:
    """Return numbers hhmmss.ss as seconds of the day, where they step as such do: from 59.9 to 100.0."""
    hour, minute, second = np.floor(numbers / 1e4), np.floor(numbers / 100.0) % 100.0, numbers % 100.0
    with np.errstate(invalid="ignore"):
        wrong = (numbers < 0.0) | (hour > 23.0) | (minute > 59.0) | (second >= 60.0)
    if wrong.any():
        return numbers, []
    time = 3600.0 * hour + 60.0 * minute + second
    before, after = np.diff(numbers), np.diff(time)
    turns = (before > 40.0) & (after < before - 39.0)
    # each turn of a minute must be a jump of the numbers and a usual step of the clock
    if not turns.any() or np.nanmedian(after[turns]) > max(10.0 * float(np.nanmedian(after)), 2.0):
        return numbers, []
    return time, ["time: taken as hhmmss, the time of the day"]


HOUR = 3600.0
"""By which clocks are put back [s]."""


def unwrapped(time: Array) -> tuple[Array, list[str]]:
    """Return each `time` [s] of the day or the week, NaN: none, without the turns at its end, and what was found."""
    good = np.flatnonzero(np.isfinite(time))
    steps = np.diff(time[good])
    for period, name in ((DAY, "midnight"), (WEEK, "the end of the week")):
        turns = steps < -0.9 * period
        if turns.any() and time[good].min() >= 0.0 and time[good].max() <= period:
            added = np.zeros(time.size)
            added[good[1:]] = period * np.cumsum(turns)
            count = int(turns.sum())
            times = {1: "once", 2: "twice"}.get(count, f"{count} times")
            return time + added, [f"time: passes {name} {times}"]
    return time, []


def gps_time(week: Array, second: Array) -> tuple[Array, list[str]]:
    """Return the Unix time [s] of each GPS `week` and `second` (or millisecond) in it, and what was done."""
    scale = 1e-3 if float(np.nanmax(second)) > WEEK else 1.0
    time = _GPS_EPOCH + WEEK * week + scale * second - _LEAP_SECONDS
    return time, [f"time: GPS week and seconds, less {_LEAP_SECONDS:g} leap seconds"]


def is_gps(week: Array, second: Array) -> bool:
    """Return whether columns `week` and `second` can be GPS weeks and the seconds or milliseconds in them."""
    if not (np.isfinite(week).any() and np.isfinite(second).any()):
        return False
    low, high = float(np.nanmin(week)), float(np.nanmax(week))
    return low >= 500.0 and high < 6000.0 and high - low <= 4.0 and float(np.nanmax(second)) <= 1e3 * WEEK


def counted_on(time: Array) -> tuple[Array, list[str]]:
    """Return each `time` [s], NaN: none, with an hour that comes twice counted on, and what was found.

    As summer time ends, it goes back once, by an hour less a usual step.
    """
    good = np.flatnonzero(np.isfinite(time))
    steps = np.diff(time[good])
    back = np.flatnonzero(steps < 0.0)
    if back.size != 1:
        return time, []
    usual = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
    if abs(steps[back[0]] + HOUR - usual) > max(3.0 * usual, 1.0):
        return time, []
    added = np.zeros(time.size)
    added[good[back[0] + 1] :] = HOUR
    return time + added, ["time: the clock was put back by an hour, as summer time ends: counted on"]


def spread(time: Array) -> tuple[Array, list[str]]:
    """Return each `time` [s], such as ten rows on each second, spread evenly to the next, and what was done."""
    good = np.flatnonzero(np.isfinite(time))
    if good.size < 10:
        return time, []
    stamps = time[good]
    starts = np.concatenate(([0], np.flatnonzero(np.diff(stamps) != 0.0) + 1))
    counts = np.diff(np.append(starts, stamps.size))
    usual = int(np.median(counts))
    if starts.size < 3 or usual < 2:
        return time, []
    steps = np.diff(stamps[starts])
    step = float(np.median(steps))
    if step <= 0.0:
        return time, []
    # the first stamp may have come before the record: its rows are the last ones of its time
    late = np.where(np.arange(starts.size) == 0, np.maximum(usual - counts, 0), 0)
    rows = np.maximum(counts, usual)
    index = np.arange(stamps.size) - np.repeat(starts, counts) + np.repeat(late, counts)
    result = time.copy()
    result[good] = stamps + index * step / np.repeat(rows, counts)
    return result, [f"time: {usual} rows on each stamp, spread evenly over {step:g} s"]
