"""Makes what the folders below share importable: `wheel_recordings`."""
