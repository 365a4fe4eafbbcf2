import dataclasses
import json
import math
import multiprocessing
import os
import uuid
from dataclasses import dataclass, field

import numpy as np
import pytest
import xarray
import zarr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sweep.storage import checksums, codec, fields, group_writer, store
from sweep.storage.cache import Latest


@dataclass(frozen=True)
class Spectrum:
    frequency: np.ndarray = field(metadata={"dims": ("frequency",), "unit": "Hz", "description": "frequency"})
    transfer: np.ndarray = field(
        metadata={"dims": ("frequency", "node"), "unit": "m2/N", "description": "transfer"}
    )
    count: np.ndarray = field(metadata={"dims": ("frequency",), "unit": "1"})
    constant: complex = field(metadata={"dims": (), "unit": "m"})
    label: str
    receivers: tuple[str, ...]
    level: int
    error: float
    slowness: complex
    extra: np.ndarray | None = field(default=None, metadata={"dims": ("extra",)})


@dataclass(frozen=True, eq=False)
class Edges:
    edge: np.ndarray = field(metadata={"dims": ("edge",), "unit": "1"})


@dataclass(frozen=True, eq=False)
class Grid:
    """What tables share."""

    frequency: np.ndarray = field(metadata={"dims": ("frequency",), "unit": "Hz"})
    edges: Edges = field(metadata={"shared_by": "level"})
    level: int


@dataclass(frozen=True)
class Table:
    """What lies in one group with others that share its grid."""

    grid: Grid = field(metadata={"shared_by": "receiver"})
    transfer: np.ndarray = field(metadata={"dims": ("frequency",), "unit": "m2/N", "called_by": "name"})
    name: str
    offset: float


EDGES = Edges(np.array([0.0, 1.0, 2.0]))
GRID = Grid(np.array([1.0, 2.0]), EDGES, 3)
TABLES = {
    "8": Table(GRID, np.array([1.0, 2.0j]), "ground", math.nan),
    "12.5": Table(GRID, np.array([3.0, 4.0j]), "ground", 12.5),
    "24": Table(dataclasses.replace(GRID), np.array([5.0, 6.0j]), "ground", 24.0),
    "rail": Table(GRID, np.array([7.0, 8.0j]), "rail", math.nan),
}
"""By label. The third one has a grid of its own, though it is the same, and the last one another name."""


def example():
    draw = np.random.default_rng(1)
    return Spectrum(
        frequency=np.array([1.0, 2.0, np.nan]),
        transfer=draw.normal(size=(3, 5)) + 1j * draw.normal(size=(3, 5)),
        count=np.arange(3),
        constant=1.0 - 2.0j,
        label="a",
        receivers=("rail", "ground"),
        level=2,
        error=math.nan,
        slowness=3.0 + math.inf * 1j,
    )


@pytest.fixture
def spectrum():
    return example()


def write(home, spectrum):
    return group_writer.write(home, "spectrum/1", spectrum, {"kind": "spectrum"})


def read(home, written):
    return store.read(home, written.group, Spectrum, written.arrays)


def assert_equal(one, other):
    for member in dataclasses.fields(one):
        np.testing.assert_equal(getattr(one, member.name), getattr(other, member.name))
        assert (
            type(getattr(one, member.name)) is type(getattr(other, member.name)) or member.name == "constant"
        )


def test_a_result_comes_back_bit_by_bit(tmp_path, spectrum):
    written = write(tmp_path, spectrum)
    assert_equal(read(tmp_path, written), spectrum)
    files = [path for path in (tmp_path / store.STORE / written.group).rglob("*") if path.is_file()]
    assert written.bytes_written == sum(path.stat().st_size for path in files)


@pytest.mark.parametrize("chunk_bytes", [200, group_writer.CHUNK_BYTES])
def test_a_group_in_the_earlier_form_comes_back(tmp_path, spectrum, monkeypatch, chunk_bytes):
    """Chunks once lay in folders of their own, `c/0/0`."""
    monkeypatch.setattr(group_writer, "CHUNK_BYTES", chunk_bytes)
    with monkeypatch.context() as earlier:
        earlier.setattr(codec, "_SEPARATOR", "/")
        written = write(tmp_path, spectrum)
    folder = tmp_path / store.STORE / written.group
    assert (folder / "transfer" / "c" / "0" / "0").is_file()
    assert_equal(read(tmp_path, written), spectrum)
    now = write(tmp_path, spectrum)
    assert now.group != written.group
    assert now.arrays == written.arrays


def test_an_array_takes_one_folder(tmp_path, spectrum):
    folder = tmp_path / store.STORE / write(tmp_path, spectrum).group
    assert {path.name for path in folder.rglob("*") if path.is_dir()} == {
        "frequency",
        "transfer",
        "count",
        "constant",
    }


def test_arrays_that_were_read_can_be_written_to(tmp_path, spectrum):
    """Others would be another type to compiled kernels, which would compile anew for them."""
    found = read(tmp_path, write(tmp_path, spectrum))
    for name in ("frequency", "transfer", "count"):
        assert getattr(found, name).flags.writeable
        assert getattr(found, name).flags.c_contiguous
        assert getattr(found, name).flags.aligned


def test_what_was_written_is_restored_as_it_is_read(tmp_path, spectrum):
    """Whatever the order of an array in memory was: arithmetic may depend on that."""
    turned = dataclasses.replace(spectrum, transfer=np.asfortranarray(spectrum.transfer))
    written = write(tmp_path, turned)
    held, found = group_writer.restore(written, Spectrum), read(tmp_path, written)
    assert_equal(held, found)
    for member in dataclasses.fields(Spectrum):
        one, other = getattr(held, member.name), getattr(found, member.name)
        if isinstance(one, np.ndarray):
            assert (one.dtype, one.strides, one.flags.writeable) == (
                other.dtype,
                other.strides,
                other.flags.writeable,
            )


def test_plain_arrays_and_attributes(tmp_path, spectrum):
    written = write(tmp_path, spectrum)
    arrays, attributes = store.read_result(tmp_path, {"group": written.group})
    np.testing.assert_array_equal(arrays["transfer"], spectrum.transfer)
    assert arrays.keys() == {"frequency", "transfer", "count", "constant"}
    assert attributes["receivers"] == ["rail", "ground"]
    assert attributes["kind"] == "spectrum"


def test_xarray_opens_it(tmp_path, spectrum):
    written = write(tmp_path, spectrum)
    with xarray.open_zarr(tmp_path / store.STORE / written.group) as dataset:
        assert dataset.transfer.dims == ("frequency", "node")
        assert dataset.transfer.attrs == {"units": "m2/N", "long_name": "transfer"}
        np.testing.assert_array_equal(dataset.transfer.values, spectrum.transfer)


def test_the_store_can_be_walked_and_a_missing_chunk_is_nan(tmp_path, spectrum):
    written = write(tmp_path, spectrum)
    array = zarr.open_group(tmp_path / store.STORE, mode="r")[f"{written.group}/transfer"]
    assert np.isnan(array.fill_value)
    assert array.chunks == (3, 5)


def test_large_arrays_are_cut_along_rows(tmp_path, spectrum, monkeypatch):
    monkeypatch.setattr(group_writer, "CHUNK_BYTES", 200)
    written = write(tmp_path, spectrum)
    array = zarr.open_group(tmp_path / store.STORE, mode="r")[f"{written.group}/transfer"]
    assert array.chunks == (2, 5)
    assert_equal(read(tmp_path, written), spectrum)


def test_arrays_of_wrong_shape_are_refused(tmp_path, spectrum):
    with pytest.raises(ValueError, match="transfer.*does not fit"):
        write(tmp_path, dataclasses.replace(spectrum, transfer=np.zeros(3)))
    with pytest.raises(ValueError, match="4 along frequency, others have 3"):
        write(tmp_path, dataclasses.replace(spectrum, count=np.arange(4)))
    assert list(tmp_path.iterdir()) == []


def assert_same_table(one, other):
    np.testing.assert_equal(one.transfer, other.transfer)
    np.testing.assert_equal((one.name, one.offset), (other.name, other.offset))
    np.testing.assert_equal(one.grid.frequency, other.grid.frequency)
    np.testing.assert_equal(one.grid.edges.edge, other.grid.edges.edge)
    assert one.grid.level == other.grid.level


def stored_together(home, *labels):
    """Store tables as one group; return what was written by label."""
    made = {label: fields.split(TABLES[label]).with_attributes(unit_id=f"id-{label}") for label in labels}
    written = group_writer.Writer(home).together("table/1", made, {"kind": "table"})
    return dict(zip(labels, written, strict=True))


@pytest.fixture(params=["needed", "whole"])
def read_member(tmp_path, request):
    """Read one of several results of a group: what is needed of it, or after a look at all metadata."""

    def one(written):
        recorded = written.group_fields()
        if request.param == "whole":
            recorded["group_metadata"] = None
        return store.read(tmp_path, result_type=Table, **recorded)

    return one


def test_results_that_differ_in_what_is_their_own_lie_together():
    keys = {label: fields.split(table).group_key for label, table in TABLES.items()}
    assert keys["8"] == keys["12.5"]
    assert len(set(keys.values())) == 3
    longer = dataclasses.replace(TABLES["8"], transfer=np.zeros(3))
    with pytest.raises(ValueError, match="3 along frequency"):
        fields.split(longer)
    level = dataclasses.replace(GRID, level=4)
    for changed in ({"grid": level}, {"transfer": np.zeros(2)}):  # real numbers do not lie among complex ones
        other = dataclasses.replace(TABLES["8"], **changed)
        assert fields.split(other).group_key != keys["8"]


@pytest.mark.parametrize("chunk_bytes", [20, group_writer.CHUNK_BYTES])
def test_results_of_one_group_are_read_one_by_one(tmp_path, read_member, monkeypatch, chunk_bytes):
    monkeypatch.setattr(group_writer, "CHUNK_BYTES", chunk_bytes)
    written = stored_together(tmp_path, "8", "12.5")
    assert written["8"].group == written["12.5"].group
    folder = tmp_path / store.STORE / written["8"].group
    assert sorted(path.name for path in folder.iterdir()) == ["edge", "frequency", "ground", "zarr.json"]
    assert sum(stored.bytes_written for stored in written.values()) == sum(
        path.stat().st_size for path in folder.rglob("*") if path.is_file()
    )
    for label, each in written.items():
        assert_same_table(read_member(each), TABLES[label])
        assert_same_table(group_writer.restore(each, Table), TABLES[label])
        store.check(tmp_path, each.group_fields())
        stored = store.read_array(tmp_path, each.group, each.member, "ground")
        np.testing.assert_array_equal(stored, TABLES[label].transfer)
        stored = store.read_array(tmp_path, each.group, each.member, "frequency")
        np.testing.assert_array_equal(stored, GRID.frequency)
    arrays, attributes = store.read_result(tmp_path, written["12.5"].group_fields())
    assert arrays.keys() == {"edge", "frequency", "ground"}
    said = {"name": "ground", "offset": 12.5, "unit_id": "id-12.5"}
    assert attributes == {"kind": "table", "level": 3, **said}


@pytest.mark.parametrize("chunk_bytes", [20, group_writer.CHUNK_BYTES])
def test_a_group_of_several_results_opens_as_one_dataset(tmp_path, monkeypatch, chunk_bytes):
    monkeypatch.setattr(group_writer, "CHUNK_BYTES", chunk_bytes)
    written = stored_together(tmp_path, "8", "12.5")
    with xarray.open_zarr(tmp_path / store.STORE / written["8"].group) as dataset:
        assert dataset.attrs == {"kind": "table", "level": 3}
        both = [TABLES[label].transfer for label in written]
        np.testing.assert_array_equal(dataset.ground.values, both)
        assert dataset.ground.dims == ("receiver", "frequency")
        assert list(dataset.ground.attrs["members"]) == ["8", "12.5"]
        assert dataset.ground.attrs["members"]["12.5"]["offset"] == 12.5
    arrays, _ = store.read_result(tmp_path, {"group": written["8"].group})
    np.testing.assert_array_equal(arrays["ground"], both)


def test_a_result_is_the_same_whichever_others_lie_with_it(tmp_path, read_member):
    alone = stored_together(tmp_path, "12.5")["12.5"]
    beside = stored_together(tmp_path, "8", "12.5")["12.5"]
    assert alone.group != beside.group
    assert (alone.arrays, alone.attributes) == (beside.arrays, beside.attributes)
    assert_same_table(read_member(alone), read_member(beside))


@pytest.mark.parametrize(("damaged", "hit"), [("frequency/c.0", {"8", "12.5"}), ("ground/c.1.0", {"12.5"})])
def test_damage_of_one_array_is_that_of_the_results_that_have_it(tmp_path, read_member, damaged, hit):
    written = stored_together(tmp_path, "8", "12.5")
    (tmp_path / store.STORE / written["8"].group / damaged).unlink()
    for label, each in written.items():
        if label in hit:
            with pytest.raises(store.DamagedError, match="table/1"):
                read_member(each)
            with pytest.raises(store.DamagedError, match="table/1"):
                store.check(tmp_path, each.group_fields())
        else:
            assert_same_table(read_member(each), TABLES[label])
            store.check(tmp_path, each.group_fields())


def test_results_that_have_changed_places_are_damaged(tmp_path, read_member):
    written = stored_together(tmp_path, "8", "12.5")
    folder = tmp_path / store.STORE / written["8"].group / "ground"
    (folder / "c.0.0").rename(folder / "aside")
    (folder / "c.1.0").rename(folder / "c.0.0")
    (folder / "aside").rename(folder / "c.1.0")
    for stored in written.values():
        with pytest.raises(store.DamagedError, match="ground is not the one recorded"):
            read_member(stored)


@pytest.mark.parametrize("path", ["zarr.json", "ground/zarr.json", "frequency/zarr.json"])
def test_altered_metadata_of_a_group_are_those_of_all_its_results(tmp_path, path):
    written = stored_together(tmp_path, "8", "12.5")
    place = tmp_path / store.STORE / written["8"].group / path
    place.write_text(place.read_text().replace('"units":"m2/N"', '"units":"m3/N"').replace('"Hz"', '"kHz"'))
    for stored in written.values():
        with pytest.raises(store.DamagedError, match="metadata"):
            store.check(tmp_path, stored.group_fields())


def test_a_record_that_names_another_result_is_damage(tmp_path, read_member):
    written = stored_together(tmp_path, "8", "12.5")
    for member in ("8", "24", None):
        with pytest.raises(store.DamagedError):
            read_member(dataclasses.replace(written["12.5"], member=member))


def test_results_that_differ_in_other_things_are_refused(tmp_path):
    level = dataclasses.replace(TABLES["8"], grid=dataclasses.replace(GRID, level=4))
    for other in (TABLES["24"], TABLES["rail"], level):
        named = {"one": fields.split(TABLES["8"]), "other": fields.split(other)}
        with pytest.raises(ValueError, match="differ in what is not their own"):
            group_writer.Writer(tmp_path).together("table/1", named, {})
    assert list(tmp_path.iterdir()) == []


def damage(home, written, how):
    group = home / store.STORE / written.group
    path = group / "transfer" / "c.0.0"
    if how == "flip":
        content = bytearray(path.read_bytes())
        content[10] ^= 1
        path.write_bytes(content)
    elif how == "truncate":
        path.write_bytes(path.read_bytes()[:-8])
    elif how == "delete":
        path.unlink()
    elif how == "metadata":
        (group / "zarr.json").write_text("{")
    elif how == "replace":
        zarr.open_group(group, mode="r+")["transfer"][0, 0] = 7.0
    return path


@pytest.mark.parametrize("how", ["flip", "truncate", "delete", "metadata", "replace"])
def test_damage_is_found_against_the_record(tmp_path, spectrum, how):
    written = write(tmp_path, spectrum)
    damage(tmp_path, written, how)
    with pytest.raises(store.DamagedError, match="spectrum/1"):
        read(tmp_path, written)


def test_altered_attributes_are_found_against_the_record(tmp_path, spectrum):
    written = write(tmp_path, spectrum)
    record = written.group_fields()
    store.check(tmp_path, record)
    path = tmp_path / store.STORE / written.group / "zarr.json"
    path.write_text(path.read_text().replace('"level":2', '"level":3'))
    assert read(tmp_path, written).level == 3
    with pytest.raises(store.DamagedError, match="metadata"):
        store.check(tmp_path, record)
    with pytest.raises(store.DamagedError, match="metadata"):
        store.read(tmp_path, written.group, Spectrum, written.arrays, written.metadata)


def test_a_missing_group_is_damage(tmp_path):
    with pytest.raises(store.DamagedError, match="spectrum/2"):
        store.read_result(tmp_path, {"group": "spectrum/2"})


def test_a_damaged_group_is_replaced(tmp_path, spectrum):
    damage(tmp_path, write(tmp_path, spectrum), "delete")
    written = write(tmp_path, spectrum)
    assert_equal(read(tmp_path, written), spectrum)
    assert list((tmp_path / f"{store.STORE}.partial").iterdir()) == []


def test_another_result_for_the_same_unit_leaves_the_first_one_alone(tmp_path, spectrum):
    first = write(tmp_path, spectrum)
    second = write(tmp_path, dataclasses.replace(spectrum, transfer=spectrum.transfer + 1.0))
    assert first.group != second.group
    assert_equal(read(tmp_path, first), spectrum)


@pytest.mark.parametrize("linking", [True, False])
def test_what_results_share_is_stored_once(tmp_path, monkeypatch, linking):
    """Each group is whole for any reader, also where a file system gives files no second name."""
    if not linking:
        link = os.link

        def of_records_alone(there, name):
            if "zarr.partial" in name:
                raise OSError
            link(there, name)

        monkeypatch.setattr(os, "link", of_records_alone)
    writer = group_writer.Writer(tmp_path)
    made = [TABLES["8"], TABLES["rail"]]
    first, second = (writer(f"table/{n}", table, {}) for n, table in enumerate(made))
    assert second.arrays["frequency"] == first.arrays["frequency"]
    for name in ("frequency", "edge"):
        files = [tmp_path / store.STORE / stored.group / name / "c.0" for stored in (first, second)]
        assert files[0].samefile(files[1]) is linking
    other = writer("table/2", dataclasses.replace(TABLES["8"], transfer=2.0 * TABLES["8"].transfer), {})
    folders = [tmp_path / store.STORE / stored.group / "ground" for stored in (first, other)]
    # The same is said of both, though they are not the same.
    assert os.path.samefile(*(folder / "zarr.json" for folder in folders)) is linking
    assert not os.path.samefile(*(folder / "c.0" for folder in folders))
    assert (other.bytes_written < first.bytes_written) is linking
    for written, table in zip((first, second), made, strict=True):
        alone = group_writer.write(tmp_path / "alone", written.group.rpartition("-")[0], table, {})
        assert (alone.group, alone.arrays, alone.metadata) == (
            written.group,
            written.arrays,
            written.metadata,
        )
        assert_same_table(store.read(tmp_path, written.group, Table, written.arrays), table)
        with xarray.open_zarr(tmp_path / store.STORE / written.group) as dataset:
            np.testing.assert_array_equal(dataset[table.name].values, table.transfer)
            assert dataset[table.name].dims == ("frequency",)


def test_what_further_groups_share_in_turn_is_stored_once(tmp_path):
    """Grids of two levels have the same edges."""
    writer = group_writer.Writer(tmp_path)
    finer = dataclasses.replace(TABLES["8"], grid=Grid(np.array([1.0, 2.5]), EDGES, 4))
    folders = [
        tmp_path / store.STORE / writer(f"table/{n}", table, {}).group
        for n, table in enumerate((TABLES["8"], finer))
    ]
    assert os.path.samefile(*(folder / "edge" / "c.0" for folder in folders))
    assert not os.path.samefile(*(folder / "frequency" / "c.0" for folder in folders))


def test_settling_forgets_what_one_group_alone_has(tmp_path):
    writer = group_writer.Writer(tmp_path)
    tables = [dataclasses.replace(TABLES["8"], transfer=n * TABLES["8"].transfer) for n in range(3)]
    alone = dataclasses.replace(TABLES["8"], grid=Grid(np.array([3.0, 4.0]), Edges(np.array([0.0, 1.0])), 3))
    groups = [writer(f"table/{n}", table, {}).group for n, table in enumerate((*tables[:2], alone))]
    writer.settle()
    groups += [writer(f"table/{n}", table, {}).group for n, table in enumerate((tables[2], alone), start=3)]
    frequency = [tmp_path / store.STORE / group / "frequency" / "c.0" for group in groups]
    assert frequency[0].samefile(frequency[1])
    assert frequency[0].samefile(frequency[3])
    assert not frequency[2].samefile(frequency[4])
    assert frequency[2].read_bytes() == frequency[4].read_bytes()


def test_what_is_in_the_place_of_something_that_is_gone_is_another(tmp_path):
    writer = group_writer.Writer(tmp_path)
    written = []
    for factor in range(20):  # each grid takes the memory of the one before
        grid = Grid(factor * GRID.frequency, EDGES, 3)
        written.append(writer("table/1", Table(grid, GRID.frequency, "ground", 0.0), {}))
        del grid
    for factor, each in enumerate(written):
        found = store.read(tmp_path, each.group, Table, each.arrays)
        np.testing.assert_array_equal(found.grid.frequency, factor * GRID.frequency)


def test_results_that_are_read_share_one_object(tmp_path):
    """Whether they lie in one group or not, and as long as one of them is in memory."""
    writer = group_writer.Writer(tmp_path)
    rail = writer("table/rail", TABLES["rail"], {})
    ground = stored_together(tmp_path, "8", "12.5")
    records = [stored.group_fields() for stored in (rail, *ground.values())]
    one, other, third = (store.read(tmp_path, result_type=Table, **record) for record in records)
    assert one.grid is other.grid is third.grid
    assert group_writer.restore(ground["8"], Table).grid is one.grid
    for changed, same_edges in (
        (Grid(GRID.frequency, EDGES, 4), True),
        (Grid(GRID.frequency, Edges(np.zeros(3)), 3), False),
    ):
        written = writer("table/2", dataclasses.replace(TABLES["8"], grid=changed), {})
        found = store.read(tmp_path, result_type=Table, **written.group_fields())
        assert found.grid is not one.grid
        assert (found.grid.edges is one.grid.edges) is same_edges
    plain = store.read(tmp_path, ground["8"].group, Table, member="8")  # with no record of the content
    assert plain.grid is not one.grid


def test_a_damaged_group_is_replaced_beside_those_with_the_same_arrays(tmp_path):
    writer = group_writer.Writer(tmp_path)
    made = [TABLES["8"], TABLES["rail"]]
    written = [writer(f"table/{n}", table, {}) for n, table in enumerate(made)]
    path = tmp_path / store.STORE / written[0].group / "frequency" / "c.0"
    path.write_bytes(path.read_bytes()[:-8])
    for stored in written:
        with pytest.raises(store.DamagedError):
            store.read(tmp_path, stored.group, Table, stored.arrays)
    for n, (each, table) in enumerate(zip(written, made, strict=True)):
        group_writer.write(tmp_path, f"table/{n}", table, {})
        assert_same_table(store.read(tmp_path, each.group, Table, each.arrays), table)


def test_what_is_said_of_arrays_is_compared_also_where_some_are_in_memory(tmp_path, spectrum):
    written = write(tmp_path, spectrum)

    def whole():
        return store.read(tmp_path, written.group, Spectrum, written.arrays, written.metadata)

    found = whole()
    path = tmp_path / store.STORE / written.group / "zarr.json"
    said = path.read_text()
    for text, other in (('level":2', 'level":3'), ("m2/N", "m2/kN"), ("consolidated", "other")):
        path.write_text(said.replace(text, other))
        with pytest.raises(store.DamagedError, match="metadata"):
            whole()
    path.write_text(said)
    assert whole().transfer is found.transfer


def test_an_array_in_memory_is_not_read_again(tmp_path, spectrum):
    """What several results have in common is held once; who asks for all to be compared gets it read."""
    written = write(tmp_path, spectrum)
    found = read(tmp_path, written)
    (tmp_path / store.STORE / written.group / "transfer" / "c.0.0").unlink()
    assert read(tmp_path, written).transfer is found.transfer
    with pytest.raises(store.DamagedError, match="transfer"):
        store.check(tmp_path, {"group": written.group, "arrays": written.arrays})
    del found
    with pytest.raises(store.DamagedError, match="transfer"):
        read(tmp_path, written)


def whole(home, written):
    record = written.arrays, written.metadata, written.group_metadata
    return store.read(home, written.group, Spectrum, *record)


@pytest.mark.parametrize("how", ["flip", "truncate", "delete", "metadata", "replace"])
def test_damage_is_found_also_where_the_array_was_read_before(tmp_path, spectrum, how):
    written = write(tmp_path, spectrum)
    assert_equal(whole(tmp_path, written), spectrum)
    damage(tmp_path, written, how)
    with pytest.raises(store.DamagedError, match="spectrum/1"):
        whole(tmp_path, written)


@pytest.fixture
def hashed(monkeypatch):
    """The arrays whose sha256 has been asked for, by their shapes."""
    shapes = []
    checksum = checksums.checksum
    monkeypatch.setattr(checksums, "checksum", lambda array: shapes.append(array.shape) or checksum(array))
    monkeypatch.setattr(checksums, "_chunks", Latest(checksums.REMEMBERED))
    return shapes


def test_an_array_is_hashed_once_but_where_all_is_to_be_compared(tmp_path, spectrum, hashed):
    written = write(tmp_path, spectrum)
    checksums._chunks.clear()  # as another process would have it
    hashed.clear()
    for _ in range(2):
        assert_equal(whole(tmp_path, written), spectrum)
    assert sorted(hashed) == [(), (3,), (3,), (3, 5)]
    store.check(tmp_path, written.group_fields())
    assert sorted(hashed) == sorted(2 * [(), (3,), (3,), (3, 5)])


@pytest.mark.parametrize("chunk_bytes", [100, group_writer.CHUNK_BYTES])
def test_what_this_process_has_written_is_not_hashed(tmp_path, spectrum, hashed, monkeypatch, chunk_bytes):
    monkeypatch.setattr(group_writer, "CHUNK_BYTES", chunk_bytes)
    written = write(tmp_path, spectrum)
    hashed.clear()
    assert_equal(whole(tmp_path, written), spectrum)
    assert hashed == []


def test_arrays_of_a_record_come_with_the_attributes_of_the_group(tmp_path, spectrum):
    written = write(tmp_path, spectrum)
    arrays, attributes = store.read_result(tmp_path, written.group_fields())
    assert arrays.keys() == written.arrays.keys()
    np.testing.assert_array_equal(arrays["transfer"], spectrum.transfer)
    assert attributes["receivers"] == ["rail", "ground"]
    del arrays
    damage(tmp_path, written, "replace")
    with pytest.raises(store.DamagedError, match="transfer is not the one recorded"):
        store.read_result(tmp_path, written.group_fields())


def test_the_arrays_remembered_are_limited(tmp_path, spectrum, hashed, monkeypatch):
    monkeypatch.setattr(checksums, "_chunks", Latest(2))
    written = write(tmp_path, spectrum)
    hashed.clear()
    for _ in range(2):
        assert_equal(whole(tmp_path, written), spectrum)
    assert len(hashed) == 8


@pytest.mark.parametrize(("entry", "other"), [("shape", [5, 3]), ("dtype", "float64"), ("sha256", "0" * 64)])
def test_another_record_of_an_array_that_was_read_is_told_apart(tmp_path, spectrum, entry, other):
    written = write(tmp_path, spectrum)
    whole(tmp_path, written)
    arrays = {**written.arrays, "transfer": {**written.arrays["transfer"], entry: other}}
    with pytest.raises(store.DamagedError, match="transfer is not the one recorded"):
        whole(tmp_path, dataclasses.replace(written, arrays=arrays))


def test_arrays_that_the_record_lacks_or_has_beside_are_damage(tmp_path, spectrum):
    written = write(tmp_path, spectrum)
    fewer = {name: each for name, each in written.arrays.items() if name != "count"}
    for arrays in (fewer, {**written.arrays, "other": written.arrays["count"]}):
        with pytest.raises(store.DamagedError, match="array (count|other)"):
            whole(tmp_path, dataclasses.replace(written, arrays=arrays))
        with pytest.raises(store.DamagedError, match="array (count|other)"):
            store.check(tmp_path, {**written.group_fields(), "arrays": arrays})


def test_a_group_repeats_what_its_arrays_say_and_that_is_what_is_read(tmp_path, spectrum):
    written = write(tmp_path, spectrum)
    group = tmp_path / store.STORE / written.group
    repeated = json.loads((group / "zarr.json").read_text())["consolidated_metadata"]["metadata"]
    assert repeated == {name: json.loads((group / name / "zarr.json").read_text()) for name in repeated}
    assert repeated.keys() == written.arrays.keys()
    (group / "transfer" / "zarr.json").write_text("{")
    assert_equal(whole(tmp_path, written), spectrum)
    with pytest.raises(store.DamagedError, match="metadata"):
        store.check(tmp_path, written.group_fields())


def test_the_same_result_again_changes_no_file(tmp_path, spectrum):
    written = write(tmp_path, spectrum)

    def files():
        return {path: path.stat().st_mtime_ns for path in (tmp_path / store.STORE).rglob("*")}

    before = files()
    assert write(tmp_path, spectrum) == written
    assert files() == before


def test_clean_removes_what_dead_writers_left(tmp_path, spectrum):
    written = write(tmp_path, spectrum)
    left = tmp_path / f"{store.STORE}.partial" / uuid.uuid4().hex
    left.mkdir()
    store.clean(tmp_path, older_than_s=60.0)
    assert left.exists()
    store.clean(tmp_path)
    assert not left.parent.exists()
    assert_equal(read(tmp_path, written), spectrum)


@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(1, 9), st.integers(1, 7), st.integers(16, 400))
def test_chunks_are_whole_rows_and_written_at_once(tmp_path, rows, nodes, chunk_bytes):
    """Whatever the sizes, all chunks of an array come from one write, and none is shared with another's."""
    made = dataclasses.replace(
        example(), frequency=np.arange(rows), transfer=np.ones((rows, nodes), complex), count=np.arange(rows)
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(group_writer, "CHUNK_BYTES", chunk_bytes)
        home = tmp_path / f"{rows}-{nodes}-{chunk_bytes}"
        written = write(home, made)
    array = zarr.open_group(home / store.STORE, mode="r")[f"{written.group}/transfer"]
    assert array.shards is None
    assert array.chunks[1] == nodes
    files = list((home / store.STORE / written.group / "transfer").glob("c.*"))
    assert len(files) == -(-rows // array.chunks[0])
    np.testing.assert_array_equal(
        store.read(home, written.group, Spectrum, written.arrays).transfer, made.transfer
    )


def test_nobody_writes_part_of_a_chunk(tmp_path, spectrum):
    """Rows that another writer has, or adds, cannot reach a chunk that is there: they are another group."""
    whole = write(tmp_path, spectrum)
    folder = tmp_path / store.STORE / whole.group
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    part = dataclasses.replace(
        spectrum, frequency=spectrum.frequency[1:], transfer=-spectrum.transfer[1:], count=spectrum.count[1:]
    )
    assert write(tmp_path, part).group != whole.group
    array = store.open_array(tmp_path, whole.group, "transfer")
    with pytest.raises(ValueError, match="read-only"):
        array[1:, :] = 7.0
    with pytest.raises(ValueError, match="read-only"):
        array.resize((4, 5))
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def _write_many(home, sign, start):
    start.wait()
    for count in range(20):
        write(home, dataclasses.replace(example(), transfer=sign * (count + 1.0) * np.ones((3, 5), complex)))


def test_writers_of_one_unit_do_not_tear_each_others_chunks(tmp_path):
    """Two processes store different results under one name, over and over: each group is one of them."""
    context = multiprocessing.get_context("spawn")
    start = context.Barrier(2)
    processes = [context.Process(target=_write_many, args=(tmp_path, sign, start)) for sign in (1.0, -1.0)]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    assert [process.exitcode for process in processes] == [0, 0]
    groups = [path for path in (tmp_path / store.STORE / "spectrum").iterdir() if path.is_dir()]
    seen = set()
    for group in groups:
        arrays, _ = store.read_result(tmp_path, {"group": f"spectrum/{group.name}"})
        (value,) = set(arrays["transfer"].ravel())
        seen.add(value)
    assert seen == {sign * (count + 1.0) for sign in (1.0, -1.0) for count in range(20)}
