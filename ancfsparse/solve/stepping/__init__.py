"""Set-up, recording and recovery of one time-stepping run."""
