"""The first call on a cluster's worker. It is pickled with its code, because the worker may not have the suite."""


def identify(solvers: tuple[str, ...], files: tuple[str, ...]):
    """The identity of the machine that runs this, or the reason why it has none."""
    try:
        from reports.running.processes import cluster_worker

        return cluster_worker.ask_identity(solvers, files)
    except Exception as problem:
        return f"the suite is missing or incomplete ({type(problem).__name__}: {problem})"
