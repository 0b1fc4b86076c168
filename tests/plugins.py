"""Plug-ins as pip would lay them out in a folder of packages."""


def lay_out(folder, package, code, drivers):
    """Write a package of one module, which offers drivers: their names, with its classes."""
    module = package.replace("-", "_")
    (folder / f"{module}.py").write_text(code)
    about = folder / f"{module}-0.1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 0.1\n")
    lines = [f"{name} = {module}:{kind}\n" for name, kind in drivers.items()]
    (about / "entry_points.txt").write_text("".join(["[mukca.drivers]\n", *lines]))
