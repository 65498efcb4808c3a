"""Exceptions: their kinds, and the error for missing optional packages."""

import pickle
import sys

import pytest

import nereus
from nereus import errors


def test_all_are_of_nereus_and_of_a_builtin_kind():
    for name in errors.__all__:
        kind = getattr(nereus, name)
        assert issubclass(kind, nereus.NereusError) and name in nereus.__all__, name
    for kind, builtin in [
        (nereus.InputError, ValueError),
        (nereus.MissingFileError, FileNotFoundError),
        (nereus.OutputExistsError, FileExistsError),
        (nereus.RunError, RuntimeError),
    ]:
        assert issubclass(kind, builtin)
        # As some packages restore exceptions, tblib for one.
        assert kind.__new__(kind, "a: text").args == ("a: text",)
        assert str(pickle.loads(pickle.dumps(kind("a: text")))) == "a: text"
    assert issubclass(nereus.MissingFileError, nereus.InputError) and issubclass(nereus.OutputExistsError, nereus.InputError)


@pytest.mark.parametrize(
    ("package", "extra", "what", "use"),
    [
        ("xarray", "xarray", "nereus.open", lambda scene, path: nereus.open(path / "a.h5")),
        ("h5py", "xarray", "reading HDF5", lambda scene, path: nereus.open(path / "a.h5")),
        ("h5py", "xarray", "nereus.focus", lambda scene, path: nereus.focus(path / "a.h5")),
        ("zarr", "dask", "a Zarr store", lambda scene, path: scene.record(path / "a.zarr")),
        ("cloudpickle", "dask", "nereus.distributed", lambda scene, path: nereus.distributed.sweep(scene, {}, len)),
        ("distributed", "dask", "nereus.distributed", lambda scene, path: nereus.distributed.record(scene, path / "a.zarr")),
    ],
)
def test_a_missing_package_is_named_with_its_remedy(scene, tmp_path, monkeypatch, package, extra, what, use):
    pytest.importorskip("xarray")
    scene.record(tmp_path / "a.h5", pulses=(0, 2), progress=False)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=rf"^{what} needs {package} \(.*remedy: pip install './python\[{extra}\]'"):
        use(scene, tmp_path)
