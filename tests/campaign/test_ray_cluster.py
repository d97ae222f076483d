"""The same campaign on a Ray cluster of several node processes, of which one dies."""

import os
from pathlib import Path

import pytest

from crazychoir_fw.campaign.bundle import Bundle, pack
from crazychoir_fw.campaign.engines import here
from crazychoir_fw.campaign.ray_engine import RayEngine
from crazychoir_fw.campaign.run import run
from crazychoir_fw.campaign.table import hash_of
from crazychoir_fw.common.errors import StateError

VARY = {"defaults.battery": {"uniform": [0.6, 1.0]}}
NODES = 3


@pytest.fixture
def cluster(monkeypatch):
    ray = pytest.importorskip("ray", reason="the cluster needs the extra `ray`")
    from ray.cluster_utils import Cluster

    monkeypatch.setenv("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    path = os.pathsep.join([str(Path.cwd()), os.environ.get("PYTHONPATH", "")])
    monkeypatch.setenv("PYTHONPATH", path)
    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    nodes = [made.add_node(num_cpus=1) for _ in range(NODES - 1)]
    ray.init(address=made.address, logging_level="ERROR", log_to_driver=False)
    yield made, nodes
    ray.shutdown()
    made.shutdown()


def test_every_flight_is_there_once_though_a_node_dies(campaign, tmp_path, cluster):
    made, nodes = cluster
    whole, seen = campaign(vary=VARY, flights=40), []
    engine = RayEngine("auto", whole)

    def watched(tasks):
        for record in engine(tasks):
            seen.append(record.number)
            if len(seen) == 4:
                made.remove_node(nodes[0], allow_graceful=False)
            yield record

    outcome = run(whole, tmp_path / "ray", watched)
    assert sorted(seen) == list(range(40))
    assert hash_of(outcome.records) == hash_of(run(whole, tmp_path / "here", here).records)


def test_files_travel_as_bytes_with_their_digest(campaign, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    whole = campaign(vary=VARY, flights=1)
    (tmp_path / "secret.key").write_text("not a mission")
    bundle = pack([whole.file, whole.mission_file])
    assert set(bundle.files) == {"campaign.yaml", "hop.yaml"}
    folder = bundle.unpack()
    assert (folder / "hop.yaml").read_bytes() == whole.mission_file.read_bytes()
    assert folder.parent.stat().st_mode & 0o777 == 0o700
    job = bundle.moved(whole.job(0, whole.rows()[0]), folder)
    assert job.mission == str(folder / "hop.yaml")


@pytest.mark.parametrize(
    ("files", "sentence"), [({"a.yaml": b"changed"}, "arrived damaged"), ({"../a.yaml": b""}, "lies outside")]
)
def test_files_that_are_not_what_they_should_be_are_refused(tmp_path, monkeypatch, files, sentence):
    from crazychoir_fw.campaign.bundle import _digest

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    digest = _digest({"a.yaml": b"content"}) if "damaged" in sentence else _digest(files)
    with pytest.raises(StateError, match=sentence):
        Bundle("/", files, digest).unpack()


@pytest.mark.parametrize(
    ("address", "sentence"),
    [("127.0.0.1:1", "no cluster answers there"), ("somewhere", "must be HOST:PORT"), ("host:99999", "must be HOST")],
)
def test_a_cluster_that_is_not_there_is_a_sentence(campaign, address, sentence):
    pytest.importorskip("ray", reason="the cluster needs the extra `ray`")
    whole = campaign(vary=VARY, flights=1)
    with pytest.raises(StateError, match=sentence):
        next(RayEngine(address, whole)([(whole.job(0, whole.rows()[0]), {})]))
