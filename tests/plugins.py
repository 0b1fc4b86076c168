"""Plug-ins as pip would lay them out in a folder of packages."""


def lay_out(folder, package, code, drivers):
    """Write a package of one module, which offers drivers: their names, with its classes."""
    module = package.replace("-", "_")
    (folder / f"{module}.py").write_text(code)
    offered = {name: f"{module}:{kind}" for name, kind in drivers.items()}
    describe(folder, package, {"mukca.drivers": offered})


def describe(folder, package, groups, summary=None):
    """Write what pip keeps of a package: its version, and its entry points by group."""
    about = folder / f"{package.replace('-', '_')}-0.1.dist-info"
    about.mkdir()
    lines = ["Metadata-Version: 2.1", f"Name: {package}", "Version: 0.1"]
    lines += [f"Summary: {summary}"] if summary else []
    (about / "METADATA").write_text("\n".join([*lines, ""]))
    text = ""
    for group, points in groups.items():
        text += "\n".join([f"[{group}]", *(f"{n} = {v}" for n, v in points.items()), ""])
    (about / "entry_points.txt").write_text(text)
