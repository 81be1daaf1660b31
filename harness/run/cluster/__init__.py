"""A run over the machines of a dask.distributed scheduler: `cells`, what a worker does; `workplace`, the coordinator's end."""
