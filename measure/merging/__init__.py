"""The sections that several sensors took of one wheel at one moment, made one."""
