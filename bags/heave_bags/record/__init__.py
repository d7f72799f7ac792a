"""Recording: the recorder of a run and the stand-alone one."""
