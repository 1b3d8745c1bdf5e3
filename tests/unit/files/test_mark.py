"""The mark in every format: readers of the format pass over it, and it tells every change of any other byte."""

import io
import json
import random
import tomllib
import warnings
import xml.etree.ElementTree as ET
import zipfile

import h5py
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from rsc.files import mark


def picture(format):
    figure = Figure(figsize=(1.0, 1.0))
    figure.subplots().plot([0.0, 1.0])
    content = io.BytesIO()
    figure.savefig(content, format=format)
    return content.getvalue()


def film():
    content, frames = io.BytesIO(), [Image.new("P", (8, 8), i) for i in range(3)]
    frames[0].save(content, "GIF", save_all=True, append_images=frames[1:], duration=40)
    return content.getvalue()


def archive():
    content = io.BytesIO()
    np.savez_compressed(content, a=np.arange(5.0))
    return content.getvalue()


def image():
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        file["a"] = np.arange(5.0)
    return content.getvalue()


def read_png(content):
    picture = Image.open(io.BytesIO(content))
    picture.load()
    assert picture.text["Comment"].startswith("Written by rsc")
    return np.asarray(picture).tolist()


def read_gif(content):
    film = Image.open(io.BytesIO(content))
    return film.n_frames, film.size, [np.asarray(film).tolist() for i in range(film.n_frames) if not film.seek(i)]


def read_zip(content):
    with zipfile.ZipFile(io.BytesIO(content)) as packed:
        assert packed.testzip() is None
    return np.load(io.BytesIO(content))["a"].tolist()


def read_hdf5(content):
    with h5py.File(io.BytesIO(content), "r") as file:
        return file["a"][...].tolist()


def read_json(content):
    read = json.loads(content)
    read.pop("mark", None)
    return read


FORMATS = {
    "PNG": (mark.PNG, lambda: picture("png"), read_png),
    "GIF": (mark.GIF, film, read_gif),
    "SVG": (mark.SVG, lambda: picture("svg"), lambda content: len(list(ET.fromstring(content).iter()))),
    "PDF": (mark.PDF, lambda: picture("pdf"), lambda content: content.index(b"%%EOF")),
    "HTML": (mark.HTML, lambda: b"<!DOCTYPE html><html></html>\n", lambda content: content[:20]),
    "TOML": (mark.TOML, lambda: b'[a]\nb = "c"\n', lambda content: tomllib.loads(content.decode())),
    "JSON": (mark.JSON, lambda: b'{"a": [1, 2]}', read_json),
    "HDF5": (mark.HDF5, image, read_hdf5),
    "ZIP": (mark.ZIP, archive, read_zip),
}


@pytest.mark.parametrize("name", FORMATS)
def test_readers_of_the_format_pass_over_the_mark(name):
    format, make, read = FORMATS[name]
    content = make()
    assert format.marked(content) != content and format.marked(content) == format.marked(content)
    if name != "PNG":  # which has its mark in what Pillow calls its texts
        assert read(format.marked(content)) == read(content)
    else:
        assert np.asarray(Image.open(io.BytesIO(content))).tolist() == read(format.marked(content))


@pytest.mark.parametrize("name", FORMATS)
def test_any_changed_byte_is_noticed(name):
    format, make, _ = FORMATS[name]
    whole, dice = format.marked(make()), random.Random(name)
    assert format.is_marked(io.BytesIO(whole), len(whole))
    for _ in range(200):
        place = dice.randrange(len(whole))
        other = whole[:place] + bytes([whole[place] ^ dice.randrange(1, 256)]) + whole[place + 1 :]
        assert not format.is_marked(io.BytesIO(other), len(other))
    for other in (whole[1:], whole[:-1], whole + b"\n", b"\n" + whole, b"", make()):
        assert not format.is_marked(io.BytesIO(other), len(other))


def test_a_dataset_with_the_mark_is_read_by_xarray(tmp_path):
    xarray = pytest.importorskip("xarray")
    path = tmp_path / "a.nc"
    with h5py.File(path, "w") as file:
        file["x"] = np.arange(3.0)
        file["x"].make_scale("x")
    path.write_bytes(mark.HDF5.marked(path.read_bytes()))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert xarray.load_dataset(path, engine="h5netcdf")["x"].values.tolist() == [0.0, 1.0, 2.0]
