"""The world: camera, recordings, store, jobs, API, page, command line."""
