"""Alarms of sea and vessel: code, severity, words."""

from __future__ import annotations

from heave_node.interface.alarm import AlarmRow, Severity, alarm_table

ALARMS = alarm_table(
    AlarmRow(
        "MRU_OUTPUT_STOPPED",
        Severity.HIGH,
        "mru",
        "the simulated MRU has published nothing for {time:.1f} s",
        "The controller loses its MRU",
        "Clear an injected fault with `heave operate fault clear mru`; else check logs/wave_vessel.log",
    ),
    AlarmRow(
        "MRU_OUTPUT_SETTLING",
        Severity.LOW,
        "mru",
        "the high-pass filter of the simulated MRU has not settled",
        "Its readings carry the status settling",
        "Wait",
    ),
    AlarmRow(
        "FILE_REPAIRED",
        Severity.LOW,
        "files",
        "values of an input file were repaired: {warnings}",
        "The repaired values are used",
        "Check the file",
    ),
)
